#include "sinew/svo/file/stream.h"

#include <algorithm>
#include <bit>
#include <chrono>

#include "sinew/base/parallel.h"
#include "sinew/bvh/box_body.h"

namespace sinew {
namespace {

constexpr size_t kMostQueued = 512;  // blocks that a frame hands to the reading thread: some 0.3 s
constexpr float kMuchLess = 0.5f;    // of a priority: then one seen block gives way to another
constexpr uint64_t kPageSize = 4096;
constexpr uint64_t kBuffers = 8;  // of details

using Clock = std::chrono::steady_clock;

uint64_t skeleton_bytes(const SvoIndex& index) {
  return index.bytes - index.detail_bytes;
}

// Bytes of a block's detail, with pages of memory at its ends.
uint64_t detail_bytes(const SvoIndex& index, uint32_t block) {
  const SvoBlock &here = index.svo.blocks[block], &next = index.svo.blocks[block + 1];
  const uint64_t bricks = next.first_brick - here.first_brick;
  const uint64_t voxels = next.first_voxel - here.first_voxel;
  return bricks * (8 + 5 + 4) + voxels * 4 + 2 * kBuffers * kPageSize;
}

// Room to unpack a block, and the ends of buffers.
uint64_t working_room(const SvoIndex& index) {
  uint64_t most = 0;
  for (uint32_t b = 0; b < index.details.size(); ++b) {
    const uint64_t cells = index.svo.blocks[b + 1].first_cell - index.svo.blocks[b].first_cell;
    most = std::max(most, index.details[b].packed + 2 * uint64_t{index.details[b].unpacked} +
                              detail_bytes(index, b) + cells * sizeof(SvoCell));
  }
  return most + 2 * kBuffers * kPageSize;
}

uint64_t largest_detail(const SvoIndex& index) {
  uint64_t most = 0;
  for (uint32_t b = 0; b < index.details.size(); ++b) {
    most = std::max(most, detail_bytes(index, b));
  }
  return most;
}

Result<void> read_skeletons(const SvoInFile& from, Svo& svo) {
  std::vector<Result<void>> results(from.index.skeletons.size());
  parallel_for(results.size(), 8, [&](size_t begin, size_t end) {
    std::vector<uint8_t> bytes;
    for (size_t i = begin; i < end; ++i) {
      const SvoPage& page = from.index.skeletons[i];
      bytes.resize(page.packed);
      results[i] = from.file->read(from.offset + page.offset, bytes);
      if (!results[i]) continue;
      results[i] = decode_skeleton(from.index, bytes, static_cast<uint32_t>(i), svo);
    }
  });
  for (const Result<void>& result : results) SINEW_CHECKED(result);
  return {};
}

}  // namespace

Result<SvoInFile> find_svo(std::shared_ptr<const RandomFile> file, uint64_t offset, uint64_t size,
                           uint64_t limit) {
  SvoInFile from;
  std::vector<uint8_t> front(std::min<uint64_t>(size, kSvoHeader));
  SINEW_CHECKED(file->read(offset, front));
  SINEW_TRY(const uint64_t bytes, svo_front(front, size));
  front.resize(bytes);
  SINEW_CHECKED(file->read(offset, front));
  SINEW_TRY(from.index, decode_svo_front(front, size, limit));
  from.file = std::move(file);
  from.offset = offset;
  from.size = size;
  from.least = skeleton_bytes(from.index) + largest_detail(from.index) + working_room(from.index);
  return from;
}

Result<Svo> PagedSvo::open(SvoInFile from, const PagingOptions& options) {
  if (options.budget < from.least) {
    return fail({ErrorKind::bad_input, "", "",
                 "needs at least " + std::to_string(from.least) +
                     " bytes of memory for its voxels, but only " + std::to_string(options.budget) +
                     " are given",
                 "give more, or use an octree of a lower resolution"});
  }
  allocate_skeletons(from.index);
  Svo svo = std::move(from.index.svo);
  from.index.svo = {};
  SINEW_CHECKED(read_skeletons(from, svo));
  svo.paging = PagedSvoPtr(std::shared_ptr<PagedSvo>(new PagedSvo(std::move(from), options, svo)));
  if (const std::string problem = validate(svo); !problem.empty()) {
    return fail(
        {ErrorKind::bad_input, "", "", "its octree is damaged: " + problem, "make the file again"});
  }
  return svo;
}

PagedSvo::PagedSvo(SvoInFile from, const PagingOptions& options, Svo& svo)
    : from_(std::move(from)),
      options_(options),
      grid_(svo.grid),
      blocks_(svo.blocks),
      cells_(svo.cells.data()),
      memory_(from_.index, svo) {
  from_.index.svo.blocks = blocks_;
  working_room_ = working_room(from_.index);
  from_.index.svo.blocks.clear();
  const size_t count = from_.index.details.size();
  wanted_.reset(new std::atomic<uint32_t>[count]);
  for (size_t i = 0; i < count; ++i) wanted_[i].store(0, std::memory_order_relaxed);
  resident_.assign(count, 0);
  state_.assign(count, State::absent);
  seen_.assign(count, 0);
  priority_.assign(count, 0.0f);
  stats_.skeleton = skeleton_bytes(from_.index);
  stats_.detail = from_.index.detail_bytes;
  stats_.least = from_.least;
  stats_.blocks = static_cast<uint32_t>(count);
  thread_ = std::thread([this] { read_blocks(); });
}

PagedSvo::~PagedSvo() {
  {
    const std::lock_guard lock(mutex_);
    stop_ = true;
  }
  work_.notify_all();
  thread_.join();
}

void PagedSvo::request(uint32_t block, float priority) {
  raise_wish(wanted_[block], std::bit_cast<uint32_t>(priority));  // bits rise with it, if positive
}

// Bytes that details may take.
uint64_t PagedSvo::room() const {
  const uint64_t fixed = stats_.skeleton + working_room_;
  return options_.budget > fixed ? options_.budget - fixed : 0;
}

void PagedSvo::publish() {
  std::vector<Loaded> loaded;
  {
    const std::lock_guard lock(mutex_);
    loaded.swap(loaded_);
  }
  for (const Loaded& one : loaded) {
    if (!one.problem.empty()) {
      if (stats_.damaged++ == 0) stats_.problem = one.problem;
      state_[one.block] = State::damaged;
      memory_.give_back(one.block);
      continue;
    }
    memory_.set_seam(one.block, one.seam);
    state_[one.block] = State::resident;
    resident_[one.block] = 1;
    ++stats_.loaded;
    ++stats_.resident;
    ++epoch_;
  }
}

// Whether anything was asked for since.
bool PagedSvo::collect() {
  bool any = false;
  for (uint32_t b = 0; b < blocks_.size() && !any && b < state_.size(); ++b) {
    any = wanted_[b].load(std::memory_order_relaxed) != 0;
  }
  if (!any) return false;  // nothing was drawn
  ++frame_;
  stats_.seen = 0;
  for (uint32_t b = 0; b < state_.size(); ++b) {
    const uint32_t bits = wanted_[b].exchange(0, std::memory_order_relaxed);
    if (bits == 0) continue;
    priority_[b] = std::bit_cast<float>(bits);
    seen_[b] = frame_;
    ++stats_.seen;
  }
  return true;
}

// Takes back what the reading thread has not begun.
void PagedSvo::recall() {
  std::vector<uint32_t> queued;
  {
    const std::lock_guard lock(mutex_);
    queued.swap(queue_);
  }
  for (const uint32_t block : queued) {
    state_[block] = State::absent;
    memory_.give_back(block);
  }
}

void PagedSvo::evict(uint32_t block) {
  resident_[block] = 0;
  state_[block] = State::absent;
  memory_.give_back(block);
  ++stats_.evicted;
  --stats_.resident;
  ++epoch_;
}

// Evicts until the block fits. `victims`: blocks that are there, the first to go last.
bool PagedSvo::make_room(uint32_t block, float priority, std::vector<uint32_t>& victims) {
  while (memory_.bytes_in_use() + memory_.missing_bytes(block) > room()) {
    if (victims.empty()) return false;
    const uint32_t victim = victims.back();
    const bool needed = !in_parts_ && seen_[victim] == frame_;
    if (needed && !(priority_[victim] < kMuchLess * priority)) return false;
    victims.pop_back();
    evict(victim);
  }
  return true;
}

// What the last frame asked for, is not there and is still to be drawn.
std::vector<uint32_t> PagedSvo::wanted() const {
  std::vector<uint32_t> wanted;
  for (uint32_t b = 0; b < state_.size() && frame_ > 0; ++b) {
    if (state_[b] != State::absent || seen_[b] != frame_) continue;
    if (!in_parts_ || drawn_[b] == 0) wanted.push_back(b);
  }
  return wanted;
}

void PagedSvo::plan() {
  recall();
  std::vector<uint32_t> wanted = this->wanted(), victims;
  for (uint32_t b = 0; b < state_.size(); ++b) {
    if (state_[b] == State::resident && (!in_parts_ || drawn_[b] != 0)) victims.push_back(b);
  }
  const auto more_urgent = [&](uint32_t a, uint32_t b) {
    return priority_[a] != priority_[b] ? priority_[a] > priority_[b] : a < b;
  };
  std::ranges::sort(wanted, more_urgent);
  if (!wanted.empty()) {
    std::ranges::sort(victims, [&](uint32_t a, uint32_t b) {
      return seen_[a] != seen_[b] ? seen_[a] > seen_[b] : more_urgent(a, b);
    });
  }
  std::vector<uint32_t> queue;
  for (const uint32_t block : wanted) {
    if (queue.size() == kMostQueued || !make_room(block, priority_[block], victims)) break;
    memory_.take(block);
    state_[block] = State::queued;
    queue.push_back(block);
  }
  stats_.missing = static_cast<uint32_t>(wanted.size());
  stats_.most = std::max(stats_.most, stats_.skeleton + working_room_ + memory_.bytes_in_use());
  if (queue.empty()) return;
  std::ranges::reverse(queue);
  {
    const std::lock_guard lock(mutex_);
    queue_ = std::move(queue);
  }
  work_.notify_one();
}

void PagedSvo::begin_frame() {
  publish();
  collect();
  plan();
  ++stats_.frames;
  if (stats_.missing > 0) ++stats_.frames_short;
}

void PagedSvo::wait_until_read() {
  std::unique_lock lock(mutex_);
  idle_.wait(lock, [&] { return queue_.empty() && !reading_; });
}

// Reads until nothing more fits.
void PagedSvo::read_all() {
  uint64_t so_far;
  do {
    plan();
    wait_until_read();
    so_far = stats_.loaded + stats_.damaged;
    publish();
  } while (stats_.loaded + stats_.damaged != so_far);
  plan();  // counts what is missing
}

bool PagedSvo::settle() {
  const uint64_t before = epoch_;
  publish();
  collect();
  read_all();
  const bool again = epoch_ != before;
  if (!again && stats_.missing > 0) ++stats_.unsettled;
  return again;
}

PagingStats PagedSvo::stats() const {
  PagingStats stats = stats_;
  stats.budget = options_.budget;
  stats.in_use = stats_.skeleton + working_room_ + memory_.bytes_in_use();
  const std::lock_guard lock(mutex_);
  stats.bytes_read = bytes_read_;
  stats.read_ms = read_ms_;
  return stats;
}

void PagedSvo::read_blocks() {
  Reader reader;
  std::unique_lock lock(mutex_);
  while (true) {
    work_.wait(lock, [&] { return stop_ || !queue_.empty(); });
    if (stop_) return;
    const uint32_t block = queue_.back();
    queue_.pop_back();
    reading_ = true;
    lock.unlock();
    const Clock::time_point start = Clock::now();
    Loaded loaded = read_block(block, reader);
    const double ms = std::chrono::duration<double, std::milli>(Clock::now() - start).count();
    lock.lock();
    reading_ = false;
    loaded_.push_back(std::move(loaded));
    bytes_read_ += from_.index.details[block].packed;
    read_ms_ += ms;
    if (queue_.empty()) idle_.notify_all();
  }
}

// An octree of one block, its selectors beginning within a word as in the whole one.
void PagedSvo::set_alone(uint32_t block, Svo& alone) const {
  const SvoBlock &here = blocks_[block], &next = blocks_[block + 1];
  const uint32_t voxel = here.first_voxel % 16;
  const uint32_t voxels = voxel + next.first_voxel - here.first_voxel;
  const uint32_t bricks = next.first_brick - here.first_brick;
  alone.grid = grid_;
  alone.blocks.assign(2, {});
  alone.blocks[0].x = here.x, alone.blocks[0].y = here.y, alone.blocks[0].z = here.z;
  alone.blocks[0].first_voxel = voxel;
  alone.blocks[1].first_cell = next.first_cell - here.first_cell;
  alone.blocks[1].first_brick = bricks;
  alone.blocks[1].first_voxel = voxels;
  alone.cells.assign(cells_ + here.first_cell, cells_ + next.first_cell);
  alone.bricks.resize(bricks);
  alone.normals.resize(voxels);
  if (from_.index.colors) {
    alone.colors.resize(voxels);
  } else {
    alone.color_ends.resize(bricks);
    alone.color_selectors.assign((voxels + 15) / 16, 0);
  }
  alone.brick_level.normals.resize(bricks);
  alone.brick_level.colors.resize(bricks);
  alone.brick_level.spreads.resize(bricks);
}

PagedSvo::Loaded PagedSvo::read_block(uint32_t block, Reader& reader) {
  const SvoPage& page = from_.index.details[block];
  reader.bytes.resize(page.packed);
  Result<void> result = from_.file->read(from_.offset + page.offset, reader.bytes);
  if (!result) return {block, {}, result.error().problem};
  set_alone(block, reader.alone);
  result = decode_detail_alone(from_.index, reader.bytes, block, reader.alone);
  if (!result) return {block, {}, result.error().problem};
  if (const std::string problem = validate_bricks(reader.alone, 0); !problem.empty()) {
    return {block, {}, "the detail of block " + std::to_string(block) + ": " + problem};
  }
  fill_level(from_.index, 0, reader.alone);
  memory_.copy(block, reader.alone);
  return {block, DetailMemory::seam_of(reader.alone), {}};
}

void begin_paging(std::span<const Svo> octrees) {
  for (const Svo& svo : octrees) {
    if (svo.paging) svo.paging->begin_frame();
  }
}

bool settle_paging(std::span<const Svo> octrees) {
  bool changed = false;
  for (const Svo& svo : octrees) {
    if (svo.paging && svo.paging->settles()) changed |= svo.paging->settle();
  }
  return changed;
}

void give_up_paging(std::span<const Svo> octrees) {
  for (const Svo& svo : octrees) {
    if (svo.paging && svo.paging->settles()) svo.paging->give_up();
  }
}

uint64_t paging_epoch(std::span<const Svo> octrees) {
  uint64_t sum = 0;
  for (const Svo& svo : octrees) {
    if (svo.paging) sum += svo.paging->epoch();
  }
  return sum;
}

PagingStats paging_stats(std::span<const Svo> octrees) {
  PagingStats sum;
  for (const Svo& svo : octrees) {
    if (!svo.paging) continue;
    const PagingStats one = svo.paging->stats();
    sum.budget += one.budget;
    sum.least += one.least;
    sum.skeleton += one.skeleton;
    sum.detail += one.detail;
    sum.in_use += one.in_use;
    sum.most += one.most;
    sum.blocks += one.blocks;
    sum.resident += one.resident;
    sum.seen += one.seen;
    sum.missing += one.missing;
    sum.loaded += one.loaded;
    sum.evicted += one.evicted;
    sum.damaged += one.damaged;
    sum.bytes_read += one.bytes_read;
    sum.read_ms += one.read_ms;
    sum.frames = std::max(sum.frames, one.frames);
    sum.frames_short = std::max(sum.frames_short, one.frames_short);
    sum.unsettled += one.unsettled;
    sum.parts = std::max(sum.parts, one.parts);
    if (sum.problem.empty()) sum.problem = one.problem;
  }
  return sum;
}

}  // namespace sinew

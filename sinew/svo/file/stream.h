// Octrees larger than memory: the skeleton (nodes, cells, corners and what moves them, levels 3 and
// above) is always there, the detail of a block (bricks, normals, colours, level 2) comes when it
// is asked for and goes when memory is short.
//
//   a frame       draws blocks that are not there by their cells, and asks for those in whose
//                 pixels or rays it would show something finer: request(), from any thread
//   begin_frame   takes over what has come since, gives back what was seen least recently, and
//                 tells the thread that reads what to read next. It waits for nothing
//   settle        waits until all that was asked for is there
//   a picture     in parts draws what is there, then what it has asked for instead, as much as
//   fits,
//                 on top of it, and so on; then it is that of the whole octree under any budget
//
// Between two calls of begin_frame(), settle() or read_part() nothing comes or goes, so that a
// frame does not depend on how fast pages are read.
#pragma once

#include <algorithm>
#include <atomic>
#include <condition_variable>
#include <cstdint>
#include <memory>
#include <mutex>
#include <span>
#include <string>
#include <thread>
#include <vector>

#include "sinew/base/random_file.h"
#include "sinew/svo/file/detail_memory.h"
#include "sinew/svo/file/file.h"

namespace sinew {

// An octree in a file, before its skeletons are read.
struct SvoInFile {
  std::shared_ptr<const RandomFile> file;
  uint64_t offset = 0, size = 0;  // of the octree in the file
  SvoIndex index;
  uint64_t least = 0;  // bytes of memory that it needs at least: the skeleton, the largest block
                       // and room to unpack it
};
// Errors name no file but are bad_input; `limit`: bytes of memory for the head.
Result<SvoInFile> find_svo(std::shared_ptr<const RandomFile> file, uint64_t offset, uint64_t size,
                           uint64_t limit);

struct PagingOptions {
  uint64_t budget = 0;  // bytes of memory: skeleton, detail and room to unpack
  bool settle = false;  // pictures are drawn again, or in parts, until everything that they show
                        // was there
};

// What a block looks like in the part of a picture that is drawn.
enum class BlockShown : uint8_t {
  cells,   // its detail is not there
  detail,  // all of it
  later,   // nothing yet
  drawn,   // what is drawn already
};

struct PagingStats {
  uint64_t budget = 0;
  uint64_t least = 0;     // that would do
  uint64_t skeleton = 0;  // bytes
  uint64_t detail = 0;    // bytes that the detail of all blocks would take
  uint64_t in_use = 0;    // bytes, with the skeleton
  uint64_t most = 0;      // ... at any time
  uint32_t blocks = 0, resident = 0;
  uint32_t seen = 0;     // blocks that the last frame asked for
  uint32_t missing = 0;  // ... and that are not there
  uint64_t loaded = 0;   // blocks, ever
  uint64_t evicted = 0;  // blocks, ever
  uint64_t damaged = 0;  // blocks that cannot be read
  uint64_t bytes_read = 0;
  double read_ms = 0.0;       // of the reading thread, unpacking included
  uint64_t frames = 0;        // calls of begin_frame()
  uint64_t frames_short = 0;  // of these, after which something that was asked for was missing
  uint64_t unsettled = 0;     // pictures that settle() left coarser than they should be
  uint64_t parts = 0;         // of pictures and shadow maps that were drawn in parts
  std::string problem;        // what is wrong with the first damaged block
};

class PagedSvo {
 public:
  // Reads all skeletons. The octree's `paging` is the object that is made. Errors: bad_input for
  // damaged files and for a budget below SvoInFile::least.
  static Result<Svo> open(SvoInFile from, const PagingOptions& options);
  ~PagedSvo();
  PagedSvo(const PagedSvo&) = delete;
  PagedSvo& operator=(const PagedSvo&) = delete;

  // Of each block 1 if its detail is there.
  std::span<const uint8_t> resident() const { return resident_; }
  // Rises when resident() changes.
  uint64_t epoch() const { return epoch_; }

  // Asks for a block, or says that one which is there was seen. The largest priority (> 0; pixels
  // that a voxel is large) of a frame counts. Any number of threads may ask at once.
  void request(uint32_t block, float priority);
  // Of each block the bits of what request() took since, for rays (bvh/box_body.h).
  std::atomic<uint32_t>* wishes() { return wanted_.get(); }

  void begin_frame();
  // Returns whether anything came or went: then the picture is to be drawn again.
  bool settle();
  // The caller draws no more, though settle() said so.
  void give_up() { ++stats_.unsettled; }
  bool settles() const { return options_.settle; }

  // A picture, or shadow maps that are drawn together, in parts. Each part draws all blocks that
  // are there and were in no part before, and asks for others; damaged ones are drawn as cells.
  //   begin_parts() draw while (end_part()) { read_part() draw } end_parts()
  void begin_parts();
  // Whether blocks that were asked for are still to be drawn: then there is another part.
  bool end_part();
  // Whether these all fit beside what is there.
  bool part_fits() const;
  // Waits for as many of them as fit, the most urgent ones, at least one. Those that are drawn make
  // room.
  void read_part();
  void end_parts() { in_parts_ = false; }
  bool in_parts() const { return in_parts_; }
  BlockShown shown(uint32_t block) const;

  // To be called by the thread that begins frames.
  // Not below PagingStats::least.
  void set_budget(uint64_t budget) { options_.budget = std::max(budget, from_.least); }
  PagingStats stats() const;

 private:
  enum class State : uint8_t { absent, queued, resident, damaged };
  struct Loaded {
    uint32_t block = 0;
    DetailMemory::Seam seam;
    std::string problem;  // empty if it is there
  };
  // What the reading thread keeps from block to block.
  struct Reader {
    std::vector<uint8_t> bytes;
    Svo alone;
  };

  PagedSvo(SvoInFile from, const PagingOptions& options, Svo& svo);
  uint64_t room() const;
  void publish();
  bool collect();
  std::vector<uint32_t> wanted() const;
  void plan();
  void read_all();
  void recall();
  bool make_room(uint32_t block, float priority, std::vector<uint32_t>& victims);
  void evict(uint32_t block);
  void wait_until_read();

  void read_blocks();
  Loaded read_block(uint32_t block, Reader& reader);
  void set_alone(uint32_t block, Svo& alone) const;

  SvoInFile from_;
  PagingOptions options_;
  VoxelGrid grid_;
  std::vector<SvoBlock> blocks_;
  const SvoCell* cells_ = nullptr;  // of the octree, wherever it is moved
  DetailMemory memory_;
  uint64_t working_room_ = 0;  // bytes

  std::unique_ptr<std::atomic<uint32_t>[]> wanted_;  // bits of the largest priority; 0: not asked
  std::vector<uint8_t> resident_;
  std::vector<State> state_;
  std::vector<uint64_t> seen_;  // the frame that last asked
  std::vector<float> priority_;
  uint64_t frame_ = 0;  // the last one that asked for anything
  uint64_t epoch_ = 0;
  bool in_parts_ = false;
  std::vector<uint8_t> drawn_;  // in a part
  PagingStats stats_;

  mutable std::mutex mutex_;
  std::condition_variable work_, idle_;
  std::vector<uint32_t> queue_;  // the most urgent last
  std::vector<Loaded> loaded_;
  bool reading_ = false, stop_ = false;
  uint64_t bytes_read_ = 0;
  double read_ms_ = 0.0;
  std::thread thread_;
};

// begin_frame() of all octrees that come and go, and settle() of those that are to settle.
void begin_paging(std::span<const Svo> octrees);
bool settle_paging(std::span<const Svo> octrees);
void give_up_paging(std::span<const Svo> octrees);
// begin_parts() and so on of those that are to settle.
bool begin_parts(std::span<const Svo> octrees);  // whether there are any
bool end_part(std::span<const Svo> octrees);
bool part_fits(std::span<const Svo> octrees);
void read_part(std::span<const Svo> octrees);
void end_parts(std::span<const Svo> octrees);
// Rises when anything of them comes or goes.
uint64_t paging_epoch(std::span<const Svo> octrees);
// Summed over them.
PagingStats paging_stats(std::span<const Svo> octrees);

}  // namespace sinew

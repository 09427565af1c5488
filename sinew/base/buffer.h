// Buffer: memory for `size` values that are not initialised, so that the system gives pages only
// to what is written.
#pragma once

#include <algorithm>
#include <cstddef>
#include <memory>
#include <type_traits>

namespace sinew {

template <class T>
class Buffer {
  static_assert(std::is_trivially_copyable_v<T>);

 public:
  Buffer() = default;
  explicit Buffer(size_t size) : size_(size) {
    if (size > 0) data_.reset(static_cast<T*>(allocate(size * sizeof(T))));
  }

  size_t size() const { return size_; }
  T* data() { return data_.get(); }
  const T* data() const { return data_.get(); }
  T& operator[](size_t i) { return data_.get()[i]; }
  const T& operator[](size_t i) const { return data_.get()[i]; }

 private:
  struct Free {
    void operator()(T* data) const { ::operator delete(data, kAlignment); }
  };
  static constexpr std::align_val_t kAlignment{std::max<size_t>(alignof(T), 64)};
  static void* allocate(size_t bytes) { return ::operator new(bytes, kAlignment); }

  std::unique_ptr<T[], Free> data_;
  size_t size_ = 0;
};

}  // namespace sinew

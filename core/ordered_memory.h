// Memory whose addresses rise in the order of allocation, for containers whose order is that of
// their addresses.
#pragma once

#include <cstddef>
#include <map>
#include <vector>

namespace keypose {

/// Some of CGAL's containers are walked, or compared, by address: with memory from the ordinary
/// heap the result of an algorithm then depends on what the program allocated before. While an
/// OrderedMemory lives, OrderedAllocator in the same thread takes from it. Only the newest one of a
/// thread may be in use; what was taken from it must be gone before it is.
class OrderedMemory {
 public:
  /// @param bytes  what may be taken at one time; only what is used becomes real
  explicit OrderedMemory(std::size_t bytes);
  ~OrderedMemory();
  OrderedMemory(const OrderedMemory&) = delete;
  OrderedMemory& operator=(const OrderedMemory&) = delete;

  /// @throws std::bad_alloc  when all is taken, or no OrderedMemory lives in this thread
  static void* Take(std::size_t bytes);
  static void Give(void* p, std::size_t bytes);

 private:
  std::size_t size_, used_ = 0;
  std::byte* block_;
  std::map<std::size_t, std::vector<void*>> spare_;  // by size
  OrderedMemory* outer_;
};

/// For the standard's and CGAL's containers.
template <class T>
struct OrderedAllocator {
  using value_type = T;
  OrderedAllocator() = default;
  template <class U>
  OrderedAllocator(const OrderedAllocator<U>&) {}
  T* allocate(std::size_t n) { return static_cast<T*>(OrderedMemory::Take(n * sizeof(T))); }
  void deallocate(T* p, std::size_t n) { OrderedMemory::Give(p, n * sizeof(T)); }
  bool operator==(const OrderedAllocator&) const { return true; }
};

}  // namespace keypose

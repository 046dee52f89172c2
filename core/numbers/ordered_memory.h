// Memory with addresses that rise in the order of allocation, for containers that are ordered by
// address.
#pragma once

#include <cstddef>
#include <map>
#include <vector>

namespace keypose {

/// Some of CGAL's containers are traversed or compared by address. With memory from the ordinary
/// heap, the result of an algorithm then depends on what the program allocated before. While an
/// OrderedMemory exists, OrderedAllocator takes memory from it in the same thread. Only the newest
/// OrderedMemory of a thread may be used. All memory must be given back before its OrderedMemory is
/// destroyed.
class OrderedMemory {
 public:
  /// @param bytes  capacity; the system only provides the pages that are used
  explicit OrderedMemory(std::size_t bytes);
  ~OrderedMemory();
  OrderedMemory(const OrderedMemory&) = delete;
  OrderedMemory& operator=(const OrderedMemory&) = delete;

  /// @throws std::bad_alloc  when the capacity is used up, or this thread has no OrderedMemory
  static void* Take(std::size_t bytes);
  static void Give(void* p, std::size_t bytes);

 private:
  std::size_t size_, used_ = 0;
  std::byte* block_;
  std::map<std::size_t, std::vector<void*>> spare_;  // by size
  OrderedMemory* outer_;
};

/// An allocator for containers of the standard library and of CGAL.
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

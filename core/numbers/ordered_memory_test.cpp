#include "core/numbers/ordered_memory.h"

#include <gtest/gtest.h>

#include <cstdint>
#include <list>
#include <new>

namespace keypose::ordered_memory_test {

TEST(OrderedMemory, AddressesRiseWithEachAllocation) {
  const OrderedMemory memory(1 << 20);
  std::list<int, OrderedAllocator<int>> list;
  for (int i = 0; i < 100; ++i) list.push_back(i);
  const int* before = nullptr;
  for (const int& value : list) {
    EXPECT_LT(reinterpret_cast<std::uintptr_t>(before), reinterpret_cast<std::uintptr_t>(&value));
    before = &value;
  }
}

TEST(OrderedMemory, GivenBackMemoryOfOneSizeIsTakenAgain) {
  const OrderedMemory memory(1 << 20);
  void* const first = OrderedMemory::Take(48);
  OrderedMemory::Give(first, 48);
  void* const second = OrderedMemory::Take(48);
  EXPECT_EQ(first, second);
  OrderedMemory::Give(second, 48);
}

TEST(OrderedMemory, BeyondItsCapacityAndWithoutOneThrows) {
  EXPECT_THROW(OrderedMemory::Take(8), std::bad_alloc);
  const OrderedMemory memory(4096);
  EXPECT_THROW(OrderedMemory::Take(1 << 20), std::bad_alloc);
}

TEST(OrderedMemory, TheNewestOneServes) {
  const OrderedMemory outer(1 << 16);
  {
    const OrderedMemory inner(4096);
    EXPECT_THROW(OrderedMemory::Take(1 << 15), std::bad_alloc);
  }
  void* const p = OrderedMemory::Take(1 << 15);
  EXPECT_NE(p, nullptr);
  OrderedMemory::Give(p, 1 << 15);
}

}  // namespace keypose::ordered_memory_test

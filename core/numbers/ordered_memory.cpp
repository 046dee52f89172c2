#include "core/numbers/ordered_memory.h"

#include <cstdlib>
#include <new>

namespace keypose {
namespace {

constexpr std::size_t kAlignment = 16;

thread_local OrderedMemory* current = nullptr;

std::size_t Rounded(std::size_t bytes) {
  return (bytes + kAlignment - 1) / kAlignment * kAlignment;
}

}  // namespace

OrderedMemory::OrderedMemory(std::size_t bytes)
    : size_(bytes), block_(static_cast<std::byte*>(std::malloc(bytes))), outer_(current) {
  current = this;
}

OrderedMemory::~OrderedMemory() {
  current = outer_;
  std::free(block_);
}

void* OrderedMemory::Take(std::size_t bytes) {
  if (!current || !current->block_) throw std::bad_alloc();
  OrderedMemory& memory = *current;
  bytes = Rounded(bytes);
  std::vector<void*>& spare = memory.spare_[bytes];
  if (!spare.empty()) {
    void* p = spare.back();
    spare.pop_back();
    return p;
  }
  if (memory.used_ + bytes > memory.size_) throw std::bad_alloc();
  void* p = memory.block_ + memory.used_;
  memory.used_ += bytes;
  return p;
}

void OrderedMemory::Give(void* p, std::size_t bytes) {
  current->spare_[Rounded(bytes)].push_back(p);
}

}  // namespace keypose

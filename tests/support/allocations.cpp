#include "tests/support/allocations.hpp"

#include <atomic>

namespace {

std::atomic<std::size_t> count{0};
std::atomic<std::size_t> largest{0};

#ifndef __SANITIZE_ADDRESS__
void note(std::size_t size) {
  ++count;
  std::size_t known = largest.load();
  while (known < size && !largest.compare_exchange_weak(known, size)) {
  }
}
#endif

}  // namespace

#ifndef __SANITIZE_ADDRESS__
extern "C" {
void* __libc_malloc(std::size_t size);                           // NOLINT
void* __libc_calloc(std::size_t number, std::size_t size);       // NOLINT
void* __libc_realloc(void* memory, std::size_t size);            // NOLINT
void* __libc_memalign(std::size_t alignment, std::size_t size);  // NOLINT

void* malloc(std::size_t size) {
  note(size);
  return __libc_malloc(size);
}
void* calloc(std::size_t number, std::size_t size) {
  note(number * size);
  return __libc_calloc(number, size);
}
void* realloc(void* memory, std::size_t size) {
  note(size);
  return __libc_realloc(memory, size);
}
void* aligned_alloc(std::size_t alignment, std::size_t size) {
  note(size);
  return __libc_memalign(alignment, size);
}
}
#endif

namespace tonus::testing {

std::size_t allocations() { return count; }
std::size_t largest_allocation() { return largest; }
void forget_allocations() { largest = 0; }

bool counts_allocations() {
#ifdef __SANITIZE_ADDRESS__
  return false;
#else
  return true;
#endif
}

}  // namespace tonus::testing

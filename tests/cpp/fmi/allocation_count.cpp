#include "allocation_count.hpp"

#include <atomic>
#include <cerrno>
#include <cstddef>

namespace {

std::atomic<long> count{0};  // NOLINT(cppcoreguidelines-avoid-non-const-global-variables)

}  // namespace

namespace truenorth::test {

long allocations() { return count; }

}  // namespace truenorth::test

// The names that glibc gives its own functions, and ours in their place; operator new calls malloc.
// NOLINTBEGIN(bugprone-reserved-identifier,cert-dcl37-c,cert-dcl51-cpp)
extern "C" {

void* __libc_malloc(std::size_t size);
void* __libc_calloc(std::size_t nmemb, std::size_t size);
void* __libc_realloc(void* ptr, std::size_t size);
void* __libc_memalign(std::size_t alignment, std::size_t size);

void* malloc(std::size_t size) {
    ++count;
    return __libc_malloc(size);
}

void* calloc(std::size_t nmemb, std::size_t size) {
    ++count;
    return __libc_calloc(nmemb, size);
}

void* realloc(void* ptr, std::size_t size) {
    ++count;
    return __libc_realloc(ptr, size);
}

void* memalign(std::size_t alignment, std::size_t size) {
    ++count;
    return __libc_memalign(alignment, size);
}

void* aligned_alloc(std::size_t alignment, std::size_t size) { return memalign(alignment, size); }

int posix_memalign(void** memptr, std::size_t alignment, std::size_t size) {
    *memptr = memalign(alignment, size);
    return *memptr == nullptr ? ENOMEM : 0;
}

}  // extern "C"
// NOLINTEND(bugprone-reserved-identifier,cert-dcl37-c,cert-dcl51-cpp)

// What Python calls. The number in the name counts the changes of the structs that it hands over.
#include "runner/loop.hpp"

#ifdef _WIN32
#define TRUENORTH_EXPORT __declspec(dllexport)
#else
#define TRUENORTH_EXPORT __attribute__((visibility("default")))
#endif

extern "C" TRUENORTH_EXPORT std::ptrdiff_t truenorth_run_2(truenorth::runner::Loop* loop, std::size_t until) {
    return truenorth::runner::run(*loop, until);
}

// What a binary with a C++ library of its own gives back when it is unloaded. libstdc++ keeps 70 kB for
// exceptions that find no memory; of a library that all programs share that does not matter, but a tool that
// loads and unloads an FMU for every run would lose as much each time.

// NOLINTBEGIN(bugprone-reserved-identifier): of libstdc++, meant for tools that look for leaks
namespace __gnu_cxx {
void __freeres();
}
// NOLINTEND(bugprone-reserved-identifier)

namespace {

[[gnu::destructor]] void unload() { __gnu_cxx::__freeres(); }

}  // namespace

// How often this process has allocated memory so far, by whatever way: malloc is replaced.
#pragma once

namespace truenorth::test {

[[nodiscard]] long allocations();

}  // namespace truenorth::test

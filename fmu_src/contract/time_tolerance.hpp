// Time stamps closer than this [s] mean the same moment: what is left of a decimal fraction after arithmetic.
#pragma once

namespace truenorth {

inline constexpr double kTimeTolerance = 1e-6;

}  // namespace truenorth

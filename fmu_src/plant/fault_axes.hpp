// Axes that a fault concerns.
#pragma once

namespace truenorth::plant {

// 1 for each axis that a fault concerns: for all of them if it is 0, else for that one, counted from 1.
template <class Axes>
Axes concerned_by(int axis) {
    Axes axes = Axes::Ones();
    if (axis != 0) {
        axes.setZero();
        axes[axis - 1] = 1.0;
    }
    return axes;
}

}  // namespace truenorth::plant

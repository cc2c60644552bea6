// The vehicle of somebody else, as the inputs external.* show it: decides whether a state is new and sound,
// and keeps what its motion is interpolated from.
#pragma once

#include <optional>
#include <string>
#include <string_view>

#include "TruthPlant/variables.hpp"
#include "plant/passage.hpp"

namespace truenorth {

class ExternalVehicle {
  public:
    using State = truth_plant::Inputs::External;

    enum class Verdict { stale, begun, followed, refused };

    // What is wrong with a state: a value that is not within its limits, NaN included.
    struct Flaw {
        std::string_view name;
        Eigen::Index element = 0;  // from 1; 0: of a scalar
        double value = 0.0;
        double least = 0.0;
        double most = 0.0;
        const char* reason = "";  // of the limits

        [[nodiscard]] std::string sentence() const;
    };

    static constexpr double kLargestLongitude = 6.3;  // a turn either way [rad]
    static constexpr double kLargestRoll = 3.15;      // half a turn either way [rad]
    static constexpr double kLargestPitch = 1.571;    // a quarter [rad]
    static constexpr double kLargestHeading = 1e6;    // whole turns may add up [rad]
    static constexpr double kLowest = -15e3;          // [m]
    static constexpr double kHighest = 100e3;         // [m]
    static constexpr double kLargestSpeed = 10e3;     // of each component [m/s]
    static constexpr double kLargestAcceleration =
        1e3;                                        // of each component, and of what velocities say [m/s2]
    static constexpr double kLargestRate = 100.0;   // likewise [rad/s]
    static constexpr double kLargestOffset = 60.0;  // of its stamps from the master's clock, and gap [s]

    // A state of which the plant's clock says that it was valid at `time`: its stamp or, without one, the
    // beginning of the step, which ends at `end` [s]. The vehicle begins at the first sound state, and anew
    // where two in a row agree with one another and not with what was before.
    Verdict read(const State& state, double time, double end);

    // Of the last verdict, if it is `refused`.
    [[nodiscard]] const Flaw& flaw() const { return flaw_; }

    [[nodiscard]] bool known() const { return latest_.has_value(); }
    // The passage between the last two points, and these; both the same while there is but one. Needs one.
    [[nodiscard]] plant::Passage passage() const;
    [[nodiscard]] plant::KnownPoint from() const { return from_.value_or(to()); }
    [[nodiscard]] plant::KnownPoint to() const { return latest_.value_or(plant::KnownPoint{}); }

    template <class Archive>
    void serialize(Archive& archive) {
        for (auto* point : {&before_, &from_, &latest_, &doubted_}) {
            bool there = point->has_value();
            plant::KnownPoint kept = point->value_or(plant::KnownPoint());
            archive(there, kept);
            *point = there ? std::optional(kept) : std::nullopt;
        }
    }

  private:
    void begin(const plant::KnownPoint& point);
    void follow(const plant::KnownPoint& point);

    std::optional<plant::KnownPoint> before_, from_, latest_;  // that have been believed
    std::optional<plant::KnownPoint> doubted_;                 // the last one, if it did not agree with them
    Flaw flaw_;
};

}  // namespace truenorth

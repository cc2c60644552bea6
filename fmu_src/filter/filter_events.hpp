// What a filter tells of in its log: the kinds of events, and the words for them.
#pragma once

#include <cstddef>
#include <cstdint>

#include "estimation/combined.hpp"
#include "estimation/innovation_gate.hpp"
#include "filter/gnss_input.hpp"
#include "filter/imu_input.hpp"

namespace truenorth {

inline constexpr std::size_t kFindings = static_cast<std::size_t>(ImuInput::Finding::clock_set) + 1;

inline const char* reason(ImuInput::Finding finding) {
    using Finding = ImuInput::Finding;
    switch (finding) {
        case Finding::not_finite:
            return "a value is not finite";
        case Finding::impossible:
            return "a rate or a force is impossible";
        case Finding::dead:
            return "no rate and no force at all: the sensor does not measure";
        case Finding::old:
            return "its time does not follow that of the last one";
        case Finding::no_increment:
            return "the force is far beyond gravity for too long: imu.delta_angle and imu.delta_velocity "
                   "must be increments over the interval, not rates";
        case Finding::jump:
            return "an axis leapt out of line; its value before was held";
        case Finding::stuck:
            return "an axis stands still; what it leaves out is doubted";
        case Finding::count_leapt:
            return "imu.sample leapt, imu.time did not: no sample was lost";
        case Finding::clock_set:
            return "imu.time leapt, the master's clock did not: the sensor's clock was set";
        case Finding::none:
            break;
    }
    return "";
}

// Why a fix is not used.
enum class Refusal : std::uint8_t {
    not_finite,
    empty,
    impossible,
    unreachable,
    frozen,
    backwards,
    future,
    uncovered,
    too_old,
    incomplete,
    coarse,
    no_channel,
    no_weight,
    beyond_gate
};

inline constexpr std::size_t kRefusals = static_cast<std::size_t>(Refusal::beyond_gate) + 1;

inline const char* reason(Refusal refusal) {
    switch (refusal) {
        case Refusal::not_finite:
            return "a value is not finite";
        case Refusal::empty:
            return "it measures nothing: no number, or sigmas beyond 10 km and 100 m/s";
        case Refusal::impossible:
            return "a value is impossible";
        case Refusal::unreachable:
            return "it is farther from the last than any vehicle goes";
        case Refusal::frozen:
            return "to the bit that of the fix before, at a speed: the receiver hangs";
        case Refusal::backwards:
            return "its time does not follow that of the fix before";
        case Refusal::future:
            return "it is from the future";
        case Refusal::uncovered:
            return "no IMU data came to cover it";
        case Refusal::too_old:
            return "it is older than the history that is kept, 2.5 s or 256 IMU samples";
        case Refusal::incomplete:
            return "a coarse stage needs position and velocity, all three components (coarse.enabled)";
        case Refusal::coarse:
            return "a coarse stage takes nothing but fixes (coarse.enabled)";
        case Refusal::no_channel:
            return "it measures nothing that the model can use";
        case Refusal::no_weight:
            return "every component lost its weight";
        case Refusal::beyond_gate:
            return "its NIS is beyond gate.threshold";
    }
    return "";
}

// Of a verdict that is neither stale nor accepted.
inline Refusal refusal_of(GnssInput::Verdict verdict) {
    switch (verdict) {
        case GnssInput::Verdict::not_finite:
            return Refusal::not_finite;
        case GnssInput::Verdict::empty:
            return Refusal::empty;
        case GnssInput::Verdict::impossible:
            return Refusal::impossible;
        case GnssInput::Verdict::frozen:
            return Refusal::frozen;
        case GnssInput::Verdict::backwards:
            return Refusal::backwards;
        case GnssInput::Verdict::late:
            return Refusal::too_old;
        default:
            return Refusal::future;
    }
}

inline Refusal refusal_of(StampClock::Verdict verdict) {
    switch (verdict) {
        case StampClock::Verdict::backwards:
            return Refusal::backwards;
        case StampClock::Verdict::late:
            return Refusal::too_old;
        default:
            return Refusal::future;
    }
}

// Of a fix whose innovation was of this NIS and so many channels.
inline Refusal refusal_of(const InnovationGate& gate, double nis, int channels) {
    if (channels == 0) {
        return Refusal::no_channel;
    }
    return !gate.enabled || gate.explains(nis, channels) ? Refusal::no_weight : Refusal::beyond_gate;
}

// Why the sigmas cannot be believed.
enum class Contradiction : std::uint8_t { none, fixes, innovations, aids, start };

inline const char* reason(Contradiction contradiction) {
    switch (contradiction) {
        case Contradiction::fixes:
            return "fixes in a row are beyond what it explains (gate.threshold)";
        case Contradiction::innovations:
            return "innovations are larger than it allows (consistency.window, consistency.limit)";
        case Contradiction::aids:
            return "measurements of an aid are beyond what it explains (gate.threshold, consistency.limit)";
        case Contradiction::start:
            return "the attitude has been corrected by more than the sigmas it set out with "
                   "(consistency.limit)";
        case Contradiction::none:
            break;
    }
    return "";
}

// What the corrector `combined` blames.
inline const char* reason(Cause cause) {
    return cause == Cause::motion ? "a motion that the IMU has not measured, or measured wrongly, is in doubt"
                                  : "position, velocity and attitude are in doubt, as far as the fixes say";
}

// What else happens many times.
enum class Notice : std::uint8_t { gap, repaired, infeasible, contradicted, silent, blamed, faulted };

inline constexpr std::size_t kNotices = static_cast<std::size_t>(Notice::faulted) + 1;

}  // namespace truenorth

// What a fuzz program does with one FMU, whose resources have a recording: whatever chance says.
#pragma once

#include <memory>
#include <string>

#include "chance.hpp"
#include "fmi/binary.hpp"
#include "watch.hpp"

namespace truenorth::fuzz {

class Session {
  public:
    explicit Session(Chance chance) : chance_(chance) {}
    Session(const Session&) = delete;
    Session(Session&&) = delete;
    Session& operator=(const Session&) = delete;
    Session& operator=(Session&&) = delete;
    virtual ~Session() = default;

    // The next thing by chance.
    virtual void go_on() = 0;

    // Whether the bytes that chance is made of are used up.
    [[nodiscard]] bool spent() const { return chance_.spent(); }

    [[nodiscard]] const Watch& watch() const { return watch_; }

  protected:
    Chance chance_;  // NOLINT(cppcoreguidelines-non-private-member-variables-in-classes)
    Watch watch_;    // NOLINT(cppcoreguidelines-non-private-member-variables-in-classes)
};

// Each program has its own.
std::unique_ptr<Session> begin_session(const test::Binary& binary, const std::string& resources,
                                       Chance chance);

}  // namespace truenorth::fuzz

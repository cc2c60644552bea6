// Where a component says what a user should know; the FMI layer passes it to the importing tool.
#pragma once

#include <string>

namespace truenorth {

class Log {
  public:
    virtual ~Log() = default;

    // True when somebody listens to events. Ask before composing a text: a step that nobody
    // listens to must not allocate.
    [[nodiscard]] virtual bool listens() const = 0;

    // Something worth a line (rejected sample, rejected fix, robust back-off, convergence).
    virtual void event(const std::string& text) = 0;

  protected:
    Log() = default;
    Log(const Log&) = default;
    Log(Log&&) = default;
    Log& operator=(const Log&) = default;
    Log& operator=(Log&&) = default;
};

}  // namespace truenorth

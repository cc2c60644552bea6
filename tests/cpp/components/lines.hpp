// A log that keeps every line.
#pragma once

#include <string>
#include <vector>

#include "contract/log.hpp"

namespace truenorth {

class Lines : public Log {
  public:
    [[nodiscard]] bool listens() const override { return true; }
    void event(const std::string& text) override { lines.push_back(text); }

    [[nodiscard]] int with(const std::string& part) const {
        int count = 0;
        for (const std::string& line : lines) count += line.find(part) != std::string::npos ? 1 : 0;
        return count;
    }

    std::vector<std::string> lines;
};

}  // namespace truenorth

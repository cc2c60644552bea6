// The binary of an FMU, loaded as a tool loads it, and what its model description says of it.
#pragma once

#include <dlfcn.h>

#include <fstream>
#include <map>
#include <mutex>
#include <regex>
#include <sstream>
#include <stdexcept>
#include <string>

namespace truenorth::test {

// libstdc++ fills a table of characters when an expression is compiled, which threads share without a lock.
[[nodiscard]] inline std::unique_lock<std::mutex> compiling() {
    static std::mutex one_at_a_time;
    return std::unique_lock(one_at_a_time);
}

class Binary {
  public:
    Binary(const std::string& binary, const std::string& description)
        : library_(dlopen(binary.c_str(), RTLD_NOW | RTLD_LOCAL)) {
        if (library_ == nullptr) {
            throw std::runtime_error(dlerror());
        }
        std::ostringstream text;
        text << std::ifstream(description).rdbuf();
        description_ = text.str();
        const auto lock = compiling();
        std::smatch match;
        if (!std::regex_search(description_, match, std::regex("(?:guid|instantiationToken)=\"([^\"]*)\""))) {
            throw std::runtime_error(description + ": no guid");
        }
        token_ = match[1];
        const std::regex variable("name=\"([^\"]*)\"\\s+valueReference=\"([0-9]+)\"");
        for (std::sregex_iterator found(description_.begin(), description_.end(), variable), end;
             found != end; ++found) {
            references_[(*found)[1]] = static_cast<unsigned>(std::stoul((*found)[2]));
        }
    }

    template <class Function>
    [[nodiscard]] Function* function(const char* name) const {
        void* const symbol = dlsym(library_, name);
        if (symbol == nullptr) {
            throw std::runtime_error(std::string(name) + " is not exported");
        }
        return reinterpret_cast<Function*>(symbol);  // NOLINT(cppcoreguidelines-pro-type-reinterpret-cast)
    }

    // The model description, its guid or instantiation token, and the references of its variables by name.
    [[nodiscard]] const std::string& description() const { return description_; }
    [[nodiscard]] const std::string& token() const { return token_; }
    [[nodiscard]] const std::map<std::string, unsigned>& references() const { return references_; }

  private:
    void* library_;  // never closed: a sanitizer names its functions at the end
    std::string description_;
    std::string token_;
    std::map<std::string, unsigned> references_;
};

}  // namespace truenorth::test

// An FMU's binary, loaded as a co-simulation master loads it.
#pragma once

#include <string>
#include <vector>

#include "binary.hpp"
#include "fmi2FunctionTypes.h"

namespace truenorth::test {

// Scalars of one type, read or written in one call.
template <class Value>
struct Port {
    std::vector<std::string> names;
    std::vector<fmi2ValueReference> references;
    std::vector<Value> values;
    bool boolean = false;  // FMI 2 has int for Boolean too, and other functions
};

class LoadedFmu {
  public:
    // The binary, and the model description that says its guid and its variables.
    LoadedFmu(const std::string& binary, const std::string& description);
    LoadedFmu(const LoadedFmu&) = delete;
    LoadedFmu(LoadedFmu&&) = delete;
    LoadedFmu& operator=(const LoadedFmu&) = delete;
    LoadedFmu& operator=(LoadedFmu&&) = delete;
    ~LoadedFmu();

    void set(const std::string& name, double value);
    void set(const std::string& name, int value);
    void start();
    void step(double time, double size);

    void read(Port<double>& port);
    void read(Port<int>& port);
    void write(const Port<double>& port);
    void write(const Port<int>& port);
    [[nodiscard]] double get(const std::string& name);

    // Stores and frees the state: something that does allocate.
    void store_state();

    [[nodiscard]] fmi2ValueReference reference(const std::string& name) const;
    // Names of the scalars of a type (Real, Integer, Boolean) and a causality (input, output).
    [[nodiscard]] std::vector<std::string> names(const std::string& type, const std::string& causality) const;

  private:
    Binary binary_;
    fmi2CallbackFunctions callbacks_{};
    fmi2Component component_ = nullptr;
    fmi2GetRealTYPE* get_real_;
    fmi2SetRealTYPE* set_real_;
    fmi2GetIntegerTYPE* get_integer_;
    fmi2SetIntegerTYPE* set_integer_;
    fmi2GetBooleanTYPE* get_boolean_;
    fmi2SetBooleanTYPE* set_boolean_;
    fmi2DoStepTYPE* do_step_;
    fmi2FreeInstanceTYPE* free_instance_;
};

}  // namespace truenorth::test

// What the C interfaces of all FMI versions have in common: a call is made on an Instance, and what it throws
// becomes a line of the log "<function>: <why>". No exception leaves a C function.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstring>
#include <exception>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "fmi/fmu.hpp"
#include "fmi/instance.hpp"
#include "fmi/refusal.hpp"
#include "fmi/start_values.hpp"

namespace truenorth::fmi {

// Runs `body` on the instance that the C handle means; whether it went well.
template <class Body>
[[nodiscard]] bool succeeds(void* handle, const char* function, Body body) noexcept {
    if (handle == nullptr) {
        return false;
    }
    auto& instance = *static_cast<Instance*>(handle);
    try {
        try {
            body(instance);
            return true;
        } catch (const std::exception& reason) {
            instance.journal().error(std::string(function) + ": " + reason.what());
        }
    } catch (...) {  // no memory for the line, or a logger that throws: the status must do
        return false;
    }
    return false;
}

template <class T>
T& present(T* pointer, const char* name) {
    if (pointer == nullptr) {
        throw Refusal(std::string(name) + " is NULL");
    }
    return *pointer;
}

template <class T>
std::span<T> array(T* pointer, std::size_t size, const char* name) {
    if (pointer == nullptr && size > 0) {
        throw Refusal(std::string(name) + " is NULL");
    }
    return {pointer, size};
}

// An enumerator that was passed, as a number: a C program may pass any, of which C++ may load but its own.
template <class Enumeration>
int number_of(const Enumeration& passed) noexcept {
    int number = 0;
    static_assert(sizeof number == sizeof passed);
    std::memcpy(&number, &passed, sizeof number);
    return number;
}

// How a tool asks for an instance, in the words of its FMI version.
struct Request {
    const char* function;
    Use use;
    const char* instance_name;
    const char* token_name;  // of the argument that names the build
    const char* token;
    const char* resources;  // URI or path of the folder; may be NULL
    bool logging;
};

inline std::filesystem::path resources_of(const Request& request) {
    return folder_of(request.resources == nullptr ? "" : request.resources);
}

inline StartValues start_values(const Request& request, std::string_view guid) {
    const std::string_view given = request.token == nullptr ? "NULL" : request.token;
    if (!given.starts_with(guid)) {
        throw Refusal(std::string(request.token_name) + " = " + std::string(given) + ": this FMU is " +
                      std::string(guid) + "; modelDescription.xml and the binary belong to different builds");
    }
    return StartValues::marked(given.substr(guid.size()), resources_of(request));
}

// nullptr, and a line of the log, when `check` or the request itself is at fault.
template <class Check>
Instance* instantiate(const Request& request, const Journal::Sink& sink, Check check) noexcept {
    try {
        const Fmu fmu = this_fmu(resources_of(request));
        try {
            check();
            if (request.instance_name == nullptr || *request.instance_name == '\0') {
                throw Refusal("instanceName is NULL or empty");
            }
            return std::make_unique<Instance>(fmu, request.use, sink, request.logging,
                                              start_values(request, fmu.identity.guid))
                .release();
        } catch (const std::exception& reason) {
            // FMI 3, too, wants the reason told, whatever `logging` is.
            Journal(sink, fmu.log, false, Journal::Off::events)
                .error(std::string(request.function) + ": " + reason.what());
        }
    } catch (...) {  // no memory, or a logger that throws
        return nullptr;
    }
    return nullptr;
}

inline void free_instance(void* handle) noexcept {
    const std::unique_ptr<Instance> last(static_cast<Instance*>(handle));
}

inline void enable_log(Instance& instance, bool on, std::span<const char* const> categories) {
    std::vector<std::string_view> names;
    for (const char* const name : categories) {
        names.emplace_back(&present(name, "a category"));
    }
    instance.journal().enable(on, names);
}

// ------------------------------------------------------------------ stored states

inline void save_state(Instance& instance, void** state) {
    void*& handle = present(state, "FMUstate");
    handle = instance.save(static_cast<State*>(handle));
}

inline void free_state(Instance& instance, void** state) {
    if (state != nullptr) {
        instance.release(static_cast<State*>(*state));
        *state = nullptr;
    }
}

template <class Byte>
void serialise_state(Instance& instance, void* state, Byte* bytes, std::size_t size) {
    static_assert(sizeof(Byte) == 1);
    const auto stored = instance.bytes(static_cast<State*>(state));
    const auto buffer = array(bytes, size, "serializedState");
    if (buffer.size() < stored.size()) {
        throw Refusal("the buffer has " + std::to_string(size) + " bytes, the state needs " +
                      std::to_string(stored.size()));
    }
    std::ranges::transform(stored, buffer.begin(), [](char byte) { return static_cast<Byte>(byte); });
}

template <class Byte>
void deserialise_state(Instance& instance, const Byte* bytes, std::size_t size, void** state) {
    void*& handle = present(state, "FMUstate");
    const auto given = array(bytes, size, "serializedState");
    const std::vector<char> content(given.begin(), given.end());
    handle = instance.import_state(content);
}

}  // namespace truenorth::fmi

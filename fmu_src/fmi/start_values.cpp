#include "fmi/start_values.hpp"

#include <algorithm>
#include <array>
#include <charconv>
#include <cstdint>
#include <fstream>
#include <locale>
#include <map>
#include <memory>
#include <sstream>

#include "components/recorded_signals.hpp"
#include "fmi/checksum.hpp"
#include "fmi/refusal.hpp"

namespace truenorth::fmi {
namespace {

constexpr const char* file_name = "start_values.txt";

// ":" and the checksum, 16 hexadecimal digits.
std::string mark_of(std::uint64_t checksum) {
    std::array<char, 16> digits{};
    auto* const end = std::to_chars(digits.begin(), digits.end(), checksum, 16).ptr;
    std::string mark(":");
    mark.append(static_cast<std::size_t>(digits.end() - end), '0');
    mark.append(digits.begin(), end);
    return mark;
}

// Of the recording in a folder, or of nothing where there is none.
std::uint64_t checksum_of_recording(const std::filesystem::path& resources) {
    std::uint64_t checksum = checksum_of("");
    std::ifstream file(resources / recorded::file_name, std::ios::binary);
    std::string piece(1U << 16U, '\0');
    while (file) {
        file.read(piece.data(), static_cast<std::streamsize>(piece.size()));
        piece.resize(static_cast<std::size_t>(file.gcount()));
        checksum = checksum_of(piece, checksum);
    }
    return checksum;
}

// The same decimal point in every environment.
std::istringstream reader_of(const std::string& text) {
    std::istringstream stream(text);
    stream.imbue(std::locale::classic());
    return stream;
}

template <class T>
void set(const Cell& cell, const std::string& text) {
    T value{};
    std::istringstream stream = reader_of(text);
    if (!(stream >> value) || stream.peek() != std::istringstream::traits_type::eof()) {
        throw Refusal(std::string(file_name) + ": " + cell.variable.name + " = " + text +
                      ": must be a value of its type");
    }
    *static_cast<T*>(cell.address) = value;
}

}  // namespace

StartValues StartValues::marked(std::string_view mark, const std::filesystem::path& resources) {
    StartValues given;
    if (mark.empty()) {
        return given;
    }
    const std::filesystem::path path = resources / file_name;
    std::ostringstream content;
    if (!(content << std::ifstream(path, std::ios::binary).rdbuf())) {
        throw Refusal("the start values of this export are not in " + path.string() +
                      "; the tool must tell the FMU where its resources are");
    }
    const std::string text = content.str();
    if (const std::string found = mark_of(checksum_of(text, checksum_of_recording(resources)));
        found != mark) {
        throw Refusal(path.string() +
                      " is corrupt, or of another export, or a recording beside it is: the mark is " + found +
                      ", modelDescription.xml has " + std::string(mark));
    }
    std::istringstream stream = reader_of(text);
    for (std::string name, value; stream >> name >> value;) {
        given.values_.emplace_back(name, value);
    }
    return given;
}

void StartValues::apply(std::span<const Cell> cells) const {
    if (values_.empty()) {
        return;
    }
    std::map<std::string_view, const Cell*> by_name;
    for (const Cell& cell : cells) {
        by_name.emplace(cell.variable.name, &cell);
    }
    for (const auto& [name, text] : values_) {
        const auto found = by_name.find(name);
        if (found == by_name.end()) {
            throw Refusal(std::string(file_name) + ": there is no variable " + name);
        }
        const Cell& cell = *found->second;
        if (cell.variable.causality == Causality::output) {
            throw Refusal(std::string(file_name) + ": " + name + " is an output and cannot be set");
        }
        switch (cell.variable.type) {
            case Type::real:
                set<double>(cell, text);
                break;
            case Type::integer:
            case Type::enumeration:
                set<int>(cell, text);
                break;
            case Type::boolean:
                set<bool>(cell, text);
                break;
        }
    }
}

std::filesystem::path folder_of(std::string_view location) {
    constexpr std::string_view scheme = "file:";
    if (!location.starts_with(scheme)) {
        return {std::u8string(location.begin(), location.end())};
    }
    std::string_view rest = location.substr(scheme.size());
    if (rest.starts_with("//")) {  // a host follows, empty or this one
        rest.remove_prefix(std::min(rest.find('/', 2), rest.size()));
    }
    std::u8string path;
    for (std::size_t i = 0; i < rest.size(); ++i) {
        auto byte = static_cast<unsigned char>(rest[i]);
        if (rest[i] == '%' && i + 2 < rest.size()) {
            const std::string_view digits = rest.substr(i + 1, 2);
            const char* const end = std::to_address(digits.end());
            unsigned char decoded = 0;
            if (std::from_chars(std::to_address(digits.begin()), end, decoded, 16).ptr == end) {
                byte = decoded;  // else a tool has not escaped its path, and means the sign itself
                i += digits.size();
            }
        }
        path += static_cast<char8_t>(byte);
    }
    const bool drive = path.size() > 2 && path[0] == u8'/' && path[2] == u8':';
    return {drive ? path.substr(1) : path};
}

}  // namespace truenorth::fmi

// Layout: 8 bytes magic, 4 bytes version of the format, 8 bytes checksum of all that follows, then
// the owner's name and guid, the FMI version, the kind of simulation, and the payload. The version and the
// checksum are looked at before anything else, so that nothing is interpreted that was not written here.
#include "fmi/snapshot.hpp"

#include <cereal/types/common.hpp>
#include <cereal/types/string.hpp>
#include <cstdint>

#include "fmi/archive.hpp"
#include "fmi/checksum.hpp"
#include "fmi/refusal.hpp"

namespace truenorth::fmi {
namespace {

constexpr std::string_view magic = "TNstate\n";
constexpr std::uint32_t format_version = 2;

const char* name_of(Kind kind) { return kind == Kind::co_simulation ? "co-simulation" : "model exchange"; }

}  // namespace

std::string pack(const Identity& owner, const Use& use, std::string_view payload) {
    std::string content;
    StateWriter{content}(std::string(owner.name), std::string(owner.guid), use.fmi_version, use.kind);
    content += payload;
    std::string bytes(magic);
    StateWriter{bytes}(format_version, checksum_of(content));
    return bytes + content;
}

std::string_view unpack(const Identity& owner, const Use& use, std::span<const char> bytes) {
    const std::string_view all(bytes.data(), bytes.size());
    if (!all.starts_with(magic)) {
        throw Refusal("these bytes are not the state of a TrueNorth FMU");
    }
    StateReader header(all.substr(magic.size()));
    std::uint32_t version = 0;
    header(version);
    if (version != format_version) {
        throw Refusal("the stored state has format version " + std::to_string(version) +
                      "; this FMU reads version " + std::to_string(format_version));
    }
    std::uint64_t checksum = 0;
    header(checksum);
    const std::string_view content = header.take(header.left());
    if (checksum_of(content) != checksum) {
        throw Refusal("the stored state is truncated or corrupt");
    }

    StateReader reader(content);
    std::string name;
    std::string guid;
    Use made_for{};
    reader(name, guid, made_for.fmi_version, made_for.kind);
    if (name != owner.name) {
        throw Refusal("the stored state is one of " + name + "; this is " + owner.name);
    }
    if (guid != owner.guid) {
        throw Refusal("the stored state is one of another build of " + name + " (" + guid + "); this is " +
                      owner.guid);
    }
    if (made_for.fmi_version != use.fmi_version) {
        throw Refusal("the stored state is one of the FMU for FMI " + std::to_string(made_for.fmi_version) +
                      "; this is the one for FMI " + std::to_string(use.fmi_version));
    }
    if (made_for.kind != use.kind) {
        throw Refusal(std::string("the stored state is one of an instance for ") + name_of(made_for.kind) +
                      "; this is one for " + name_of(use.kind));
    }
    return reader.take(reader.left());
}

}  // namespace truenorth::fmi

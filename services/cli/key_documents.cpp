#include "services/cli/key_documents.hpp"

#include <algorithm>
#include <spdlog/fmt/fmt.h>

#include "rig_agent/drivers/comedi_config.hpp"
#include "services/protocol/protocol.hpp"
#include "services/simulation/cohort.hpp"

namespace tonus::cli {
namespace {

/// The keys of all kinds of protocol, each once, with the kinds that have it.
KeyDocument protocol_document() {
  KeyDocument document{
      "protocol",
      "What an experiment does (`deploy/protocols`, `tonus run`). Keys of some kinds only name these.",
      {},
      explain::protocol_key_texts(),
      {}};
  for (const auto kind : protocol::kProtocolKinds) {
    for (auto& key : protocol::protocol_keys(kind)) {
      const auto known =
          std::ranges::find_if(document.keys, [&](const auto& other) { return other.name == key.name; });
      const auto at = static_cast<std::size_t>(known - document.keys.begin());
      if (known == document.keys.end()) {
        document.keys.push_back(std::move(key));
        document.kinds.emplace_back(kind_name(kind));
      } else {
        document.kinds[at] += std::string(", ") + kind_name(kind);
      }
    }
  }
  std::string all;
  for (const auto kind : protocol::kProtocolKinds)
    all += (all.empty() ? "" : ", ") + std::string(kind_name(kind));
  for (auto& kinds : document.kinds) {
    if (kinds == all) kinds.clear();
  }
  return document;
}

bool is_named(std::string_view key, std::string_view name) {
  return key == name || (key.ends_with(name) && key[key.size() - name.size() - 1] == '.');
}

std::string preset_of(const config::Key& key) {
  if (key.is_needed) return "must be given";
  return key.preset.empty() ? "none" : key.preset;
}

/// Without the unit that the expectation itself may end with.
std::string unit_beside(const config::Key& key) {
  const std::string unit = config::unit_of(key.name);
  return unit.empty() || key.expected.ends_with(" " + unit) ? "" : " " + unit;
}

std::string cell(std::string_view text) {
  std::string out;
  for (const char c : text) out += c == '|' ? std::string("\\|") : std::string(1, c);
  return out;
}

}  // namespace

std::vector<KeyDocument> key_documents() {
  return {protocol_document(),
          {"profile",
           "A rig and its simulated subject (`deploy/profiles/default.toml`, `--profile`). The file of a "
           "real rig, "
           "`/etc/tonus/rigs/NAME.toml`, has the same keys, and the agent's options in `[agent]`.",
           simulation::profile_keys(),
           explain::profile_key_texts(),
           {}},
          {"cohort",
           "The simulated subjects of a study (`deploy/profiles/cohort.toml`, `--cohort`). `[common]` has "
           "the keys of "
           "a profile, each `[[subject]]` also those of a profile's `[subject]`.",
           simulation::cohort_keys(),
           explain::cohort_key_texts(),
           {}},
          {"comedi",
           "What is connected to a data acquisition card (`--driver-file` of driver `comedi`). Two numbers "
           "are the "
           "inner and the outer joint, or the sensor's x and y axis; one number stands for both.",
           drivers::comedi_keys(),
           explain::comedi_key_texts(),
           {}}};
}

std::string_view meaning_of(const KeyDocument& document, std::string_view key) {
  const auto found = std::ranges::find(document.texts, key, &explain::KeyText::name);
  return found == document.texts.end() ? std::string_view() : found->what;
}

std::string explained_keys(std::string_view name) {
  std::string text;
  for (const auto& document : key_documents()) {
    for (std::size_t i = 0; i < document.keys.size(); ++i) {
      const auto& key = document.keys[i];
      if (name.empty() || !is_named(key.name, name)) continue;
      const bool has_kinds = i < document.kinds.size() && !document.kinds[i].empty();
      text +=
          fmt::format("{}{} (key of a {}{})\n  {}\n  expected: {}{}; default: {}\n", text.empty() ? "" : "\n",
                      key.name, document.name, has_kinds ? " of kind " + document.kinds[i] : "",
                      meaning_of(document, key.name), key.expected, unit_beside(key), preset_of(key));
    }
  }
  return text;
}

std::string keys_page() {
  std::string page =
      "# Keys of the files\n\n"
      "Every key of protocols, profiles, cohorts and wirings, as the programs check it. `x[]` is one of "
      "several tables\n"
      "`[[x]]`. Names bear their unit. `tonus explain KEY` prints one of them. The keys of `tonus.toml` are "
      "the programs'\n"
      "options: [options](options.md).\n";
  for (const auto& document : key_documents()) {
    page += fmt::format("\n## {}\n\n{}\n\n| key | what | type and range | default |\n|---|---|---|---|\n",
                        document.name, document.about);
    for (std::size_t i = 0; i < document.keys.size(); ++i) {
      const auto& key = document.keys[i];
      const bool has_kinds = i < document.kinds.size() && !document.kinds[i].empty();
      page += fmt::format("| `{}` | {}{} | {}{} | {} |\n", key.name, cell(meaning_of(document, key.name)),
                          has_kinds ? " (" + document.kinds[i] + ")" : "", cell(key.expected),
                          unit_beside(key), cell(preset_of(key)));
    }
  }
  return page;
}

}  // namespace tonus::cli

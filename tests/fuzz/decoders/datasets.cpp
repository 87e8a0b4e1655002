#include <algorithm>
#include <filesystem>

#include "services/recording/dataset.hpp"
#include "services/recording/file_name.hpp"
#include "services/recording/json_file.hpp"
#include "tests/fuzz/decoders/decoder.hpp"
#include "tests/fuzz/target.hpp"

namespace tonus::fuzz {
namespace {

namespace fs = std::filesystem;

/// A dataset of two runs, made once.
struct Whole {
  fs::path root = fs::path(scratch_folder()) / "dataset";
  std::vector<std::string> files;
  std::vector<Bytes> contents;

  Whole() {
    require(make_dataset(root).has_value(), "a dataset can be made");
    for (const auto& entry : fs::recursive_directory_iterator(root))
      if (entry.is_regular_file()) files.push_back(entry.path().string());
    std::sort(files.begin(), files.end());
    for (const auto& file : files) contents.push_back(read_bytes(file));
  }
};

const Whole& whole() {
  static const Whole kWhole;
  return kWhole;
}

}  // namespace

void read_bids(std::span<const std::byte> input) {
  Parts parts(input);
  const std::size_t which = parts.byte() % whole().files.size();
  const auto content = parts.rest();
  write_bytes(whole().files[which], Bytes(content.begin(), content.end()));
  auto dataset = recording::Dataset::open(whole().root);
  require_message(dataset);
  for (std::size_t run = 0; dataset && run < dataset->runs(); ++run) require_message(dataset->read(run));
  write_bytes(whole().files[which], whole().contents[which]);
}

std::vector<Bytes> bids_seeds() {
  std::vector<Bytes> seeds;
  for (std::size_t i = 0; i < whole().files.size(); ++i) {
    seeds.push_back({static_cast<std::byte>(i)});
    seeds.back().insert(seeds.back().end(), whole().contents[i].begin(), whole().contents[i].end());
  }
  return seeds;
}

void read_json(std::span<const std::byte> input) {
  const fs::path file = fs::path(scratch_folder()) / "x.json";
  write_bytes(file.string(), Bytes(input.begin(), input.end()));
  const auto json = recording::JsonFile::read(file);
  require_message(json);
  if (!json) return;
  require_message(json->number("Rig.HandleMass_kg"));
  require_message(json->numbers("Rig.Home_m", 2));
  require_message(json->matrix("Rig.Calibration", 2));
  require_message(json->text("TaskName", ""));
}

std::vector<Bytes> json_seeds() {
  return {bytes_of(R"({"TaskName": "unloaded", "Rig": {"HandleMass_kg": 1.5, "Home_m": [0.0, 0.45],
                    "Calibration": [[1.0, 0.0], [0.0, 1e0]]}})")};
}

}  // namespace tonus::fuzz

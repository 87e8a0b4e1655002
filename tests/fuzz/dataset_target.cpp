#include <algorithm>
#include <stdexcept>

#include "services/recording/dataset.hpp"
#include "tests/fuzz/target.hpp"

namespace tonus::fuzz {
namespace {

namespace fs = std::filesystem;

class DatasetTarget final : public Target {
 public:
  explicit DatasetTarget(const fs::path& folder) : root_(folder / "dataset") {
    if (auto made = make_dataset(root_); !made) throw std::runtime_error(made.error().message);
    if (auto read = recording::read_dataset(root_); !read) throw std::runtime_error(read.error().message);
    for (const auto& entry : fs::recursive_directory_iterator(root_)) {
      if (entry.is_regular_file()) files_.push_back(entry.path().string());
    }
    std::sort(files_.begin(), files_.end());
  }

  [[nodiscard]] std::string name() const override { return "datasets"; }

  Result<bool> run(Damage& damage) override {
    const std::string& file = files_[damage.draw(0, files_.size() - 1)];
    const Bytes whole = read_bytes(file);
    Bytes bytes = whole;
    damage.apply(bytes);
    write_bytes(file, bytes);
    const auto recordings = recording::read_dataset(root_);
    if (const auto kept = recording::Dataset::open(root_, recording::Imperfect::kLeftOut)) {
      for (std::size_t i = 0; i < kept->runs(); ++i) static_cast<void>(kept->read(i));
    }
    write_bytes(file, whole);
    if (recordings) return false;
    if (auto good = check_message(recordings.error().message); !good) return good.error();
    return true;
  }

 private:
  fs::path root_;
  std::vector<std::string> files_;
};

}  // namespace

std::unique_ptr<Target> make_dataset_target(const fs::path& folder) {
  return std::make_unique<DatasetTarget>(folder);
}

}  // namespace tonus::fuzz

#include <algorithm>
#include <spdlog/fmt/fmt.h>
#include <stdexcept>

#include "tests/fuzz/target.hpp"
#include "tests/support/process.hpp"

namespace tonus::fuzz {
namespace {

namespace fs = std::filesystem;
using testing::Process;

constexpr std::chrono::seconds kPatience{60};

class ProgramTarget final : public Target {
 public:
  ProgramTarget(fs::path folder, fs::path tonus) : folder_(std::move(folder)), tonus_(std::move(tonus)) {
    can_recover_ = knows("recover");
    can_import_ = knows("import");
    const std::string whole = (folder_ / "whole.sqlite").string();
    if (auto made = make_store(whole); !made) throw std::runtime_error(made.error().message);
    whole_ = read_bytes(whole);
    if (auto made = make_dataset(folder_ / "dataset"); !made) throw std::runtime_error(made.error().message);
    for (const auto& entry : fs::recursive_directory_iterator(folder_ / "dataset")) {
      if (entry.is_regular_file()) files_.push_back(entry.path().string());
    }
    std::sort(files_.begin(), files_.end());
  }

  [[nodiscard]] std::string name() const override {
    return fmt::format("programs ({}{})", can_recover_ ? "recover " : "", can_import_ ? "import" : "");
  }
  [[nodiscard]] bool is_of_use() const { return can_recover_ || can_import_; }

  Result<bool> run(Damage& damage) override {
    const bool is_to_recover = can_recover_ && (!can_import_ || damage.draw(0, 1) == 0);
    return is_to_recover ? recover(damage) : import(damage);
  }

 private:
  bool knows(const std::string& command) const {
    Process help(tonus_, {"--help"}, folder_ / "help");
    return help.wait(kPatience) == 0 && help.output().find("\n  " + command + " ") != std::string::npos;
  }

  Result<bool> recover(Damage& damage) {
    const std::string file = (folder_ / "damaged.sqlite").string();
    for (const auto& entry : fs::directory_iterator(folder_)) {
      if (entry.path().filename().string().starts_with("damaged.")) fs::remove_all(entry.path());
    }
    Bytes bytes = whole_;
    damage.apply(bytes);
    write_bytes(file, bytes);
    return judge({"recover", file});
  }

  Result<bool> import(Damage& damage) {
    const std::string& file = files_[damage.draw(0, files_.size() - 1)];
    const Bytes whole = read_bytes(file);
    Bytes bytes = whole;
    damage.apply(bytes);
    write_bytes(file, bytes);
    const fs::path store = folder_ / "imported.sqlite";
    fs::remove(store);
    auto judged = judge({"import", (folder_ / "dataset").string(), "--store", store.string()});
    write_bytes(file, whole);
    return judged;
  }

  Result<bool> judge(const std::vector<std::string>& arguments) {
    Process process(tonus_, arguments, folder_ / "output");
    const int code = process.wait(kPatience);
    const std::string output = process.output();
    if (code < 0 || output.find("Sanitizer") != std::string::npos) {
      const std::string kept = (folder_.parent_path() / "tonus-fuzz-failure").string();
      fs::copy(folder_, kept, fs::copy_options::recursive | fs::copy_options::overwrite_existing);
      return fail(ErrorCode::kInternal, fmt::format("tonus {} ended with {}; its input is in {}: {}",
                                                    arguments[0], code, kept, output));
    }
    if (code != 0 && output.empty())
      return fail(ErrorCode::kInternal, fmt::format("tonus {} failed without a word", arguments[0]));
    return code != 0;
  }

  fs::path folder_;
  fs::path tonus_;
  bool can_recover_ = false;
  bool can_import_ = false;
  Bytes whole_;
  std::vector<std::string> files_;
};

}  // namespace

std::unique_ptr<Target> make_program_target(const fs::path& folder, const fs::path& tonus) {
  if (!fs::exists(tonus)) return nullptr;
  auto target = std::make_unique<ProgramTarget>(folder, tonus);
  if (!target->is_of_use()) return nullptr;
  return target;
}

}  // namespace tonus::fuzz

#include "tests/fault/archive/crash_campaign.hpp"

#include <spdlog/fmt/fmt.h>

#include "services/store/sqlite.hpp"
#include "services/store/sqlite_store.hpp"

namespace tonus::archive::testing {
namespace {

constexpr std::uint64_t kMostCrashesOfAFile = 12;

Error lost(const std::string& file, const std::string& what) {
  return fail(ErrorCode::kDataLoss, file + ": " + what);
}

}  // namespace

CrashCampaign::CrashCampaign(std::filesystem::path folder, std::uint64_t seed)
    : folder_(std::move(folder)), generator_(seed) {}

std::uint64_t CrashCampaign::draw(std::uint64_t low, std::uint64_t high) {
  return std::uniform_int_distribution<std::uint64_t>(low, high)(generator_);
}

void CrashCampaign::begin_file() {
  if (!file_.empty()) {
    for (const char* suffix : {"", "-wal", "-shm", "-journal", "-lock"})
      std::filesystem::remove(file_ + suffix);
  }
  ++counts_.files;
  crashes_left_ = draw(1, kMostCrashesOfAFile);
  file_ = (folder_ / fmt::format("study-{}.sqlite", counts_.files)).string();
  rig_.emplace(counts_.files);
}

Result<void> CrashCampaign::crash() {
  if (crashes_left_ == 0) begin_file();
  --crashes_left_;
  const std::size_t receipts = rig_->receipts();
  const std::uint64_t through = rig_->through();
  if (auto lived = live(file_, *rig_); !lived) return lost(file_, lived.error().message);
  ++counts_.crashes;
  counts_.receipts += rig_->receipts() - receipts;
  counts_.samples += rig_->through() - through;
  return check(file_);
}

Result<void> CrashCampaign::check(const std::string& file) {
  if (rig_->receipts() == 0 && !std::filesystem::exists(file)) return {};  // never came to be
  auto store = store::SqliteStore::open(file, store::SqliteStore::Access::kWrite);
  if (!store) return lost(file, "cannot be opened: " + store.error().message);
  if (auto whole = rig_->check(**store); !whole) return lost(file, whole.error().message);
  store->reset();
  auto database = store::Database::open(file, store::Database::Mode::kReadWrite);
  if (!database) return lost(file, database.error().message);
  const auto verdict = database->text("PRAGMA integrity_check");
  if (!verdict) return lost(file, verdict.error().message);
  if (*verdict != "ok") return lost(file, "integrity_check: " + *verdict);
  return {};
}

}  // namespace tonus::archive::testing

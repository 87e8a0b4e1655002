#include "services/archive/disk_budget.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <spdlog/fmt/fmt.h>

namespace tonus::archive {
namespace {

/// Of the limit that is used before a session is paused.
constexpr double kUsedOfLimit = 0.95;

std::uint64_t beyond(std::uint64_t value, std::uint64_t floor) { return value > floor ? value - floor : 0; }

}  // namespace

std::string size_text(std::uint64_t bytes) {
  const auto value = static_cast<double>(bytes);
  if (value >= 1e9) return fmt::format("{:.1f} GB", value / 1e9);
  if (value >= 1e6) return fmt::format("{:.1f} MB", value / 1e6);
  if (value >= 1e3) return fmt::format("{:.1f} kB", value / 1e3);
  return fmt::format("{} B", bytes);
}

void DiskBudget::note_rate(double sample_rate_Hz) {
  rate_ = std::isfinite(sample_rate_Hz) ? std::max(0.0, sample_rate_Hz) : 0.0;
}

void DiskBudget::note_blocks(std::uint64_t payload_bytes, std::uint64_t samples) {
  if (samples > 0) bytes_per_sample_ = static_cast<double>(payload_bytes) / static_cast<double>(samples);
}

void DiskBudget::note_session(bool has_begun, double remaining_s) {
  session_ = Session{has_begun, std::isfinite(remaining_s) ? std::max(0.0, remaining_s) : 0.0};
}

std::optional<std::uint64_t> DiskBudget::available() const {
  if (!space_) return std::nullopt;
  std::optional<std::uint64_t> available;
  if (space_->free_bytes) available = beyond(*space_->free_bytes, options_.reserve_bytes);
  if (options_.limit_bytes) {
    const auto usable = static_cast<std::uint64_t>(kUsedOfLimit * static_cast<double>(*options_.limit_bytes));
    const std::uint64_t left = beyond(usable, space_->used_bytes);
    available = std::min(available.value_or(left), left);
  }
  return available;
}

std::uint64_t DiskBudget::needed() const {
  if (!session_) return 0;
  const double bytes = session_->remaining * rate_ * bytes_per_sample_ * kMargin;
  return static_cast<std::uint64_t>(std::min(bytes, 1e18));
}

std::string DiskBudget::where() const {
  std::string text;
  if (space_->free_bytes) {
    text = fmt::format("{} are free on its disk, {} stay free", size_text(*space_->free_bytes),
                       size_text(options_.reserve_bytes));
  }
  if (options_.limit_bytes) {
    text += fmt::format("{}it has {} of {}", text.empty() ? "" : "; ", size_text(space_->used_bytes),
                        size_text(*options_.limit_bytes));
  }
  return text;
}

std::string DiskBudget::refusal() const {
  const auto room = available();
  if (!room) return {};
  if (*room == 0) return fmt::format("store '{}': its disk budget is used up: {}", store_name_, where());
  if (!session_ || session_->has_begun || needed() <= *room) return {};
  return fmt::format("store '{}': the session needs about {}, {} are available: {}", store_name_,
                     size_text(needed()), size_text(*room), where());
}

}  // namespace tonus::archive

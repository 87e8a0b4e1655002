#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "services/store/store.hpp"

namespace tonus::archive {

/// Whether there is room for what a session will bring.
///
/// Available is what may still be stored: the smaller of what is free on the disk beyond `reserve_bytes`, and
/// what the store's size leaves of 95 % of `limit_bytes`. The reserve, and the last 5 % of the limit, are for
/// the trial that runs when the room ends, and for everything else that writes to the disk.
///
/// A session that has not begun needs
///
///     remaining time (s) x rate of the rig (Hz) x bytes a sample x 1.25,
///
/// remaining time being the scheduler's estimate from the plan, bytes a sample those of the blocks that came
/// so far (before any: 96, the message's), and 1.25 what indexes, other messages and repeated trials add. One
/// that runs is refused only when nothing is available any more: it may well need less than was estimated.
///
/// Pure; for one thread.
class DiskBudget {
 public:
  struct Options {
    std::optional<std::uint64_t> limit_bytes;  ///< Of the store; none: its disk is the limit.
    std::uint64_t reserve_bytes = std::uint64_t{1} << 30U;
  };
  static constexpr double kBytesPerSample = 96.0;
  static constexpr double kMargin = 1.25;

  DiskBudget(std::string store_name, const Options& options)
      : store_name_(std::move(store_name)), options_(options) {}

  void note_space(const store::StoreSpace& space) { space_ = space; }
  void note_rate(double sample_rate_Hz);  ///< Not finite or not above 0: as if not said.
  void note_blocks(std::uint64_t payload_bytes, std::uint64_t samples);  ///< All that came so far.

  /// How the session stands that is the newest: whether a trial of it was begun, and what is left of it, s.
  void note_session(bool has_begun, double remaining_s);
  void note_no_session() { session_.reset(); }

  /// Bytes that may still be stored; none where neither disk nor limit is known.
  [[nodiscard]] std::optional<std::uint64_t> available() const;

  /// Bytes that the newest session will still bring; 0 without one, or while the rig's rate is not known.
  [[nodiscard]] std::uint64_t needed() const;

  [[nodiscard]] bool has_begun() const { return session_ && session_->has_begun; }

  /// Why no trial may be begun now, a line for a person; empty: there is room.
  [[nodiscard]] std::string refusal() const;

 private:
  struct Session {
    bool has_begun = false;
    double remaining = 0.0;
  };
  [[nodiscard]] std::string where() const;

  std::string store_name_;
  Options options_;
  std::optional<store::StoreSpace> space_;
  std::optional<Session> session_;
  double rate_ = 0.0;
  double bytes_per_sample_ = kBytesPerSample;
};

/// "1.5 GB", "20.0 MB", "3.1 kB" or "17 B"; powers of ten.
[[nodiscard]] std::string size_text(std::uint64_t bytes);

}  // namespace tonus::archive

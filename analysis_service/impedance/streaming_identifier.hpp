#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "analysis_service/impedance/identification.hpp"
#include "analysis_service/impedance/trial.hpp"
#include "services/core/result.hpp"
#include "services/mechanics/rig_geometry.hpp"

namespace tonus::impedance {

/// Identifies one condition as its samples arrive: method state_variable, models (3) and (13).
///
/// Contract: begin_trial(), push_rest() for the samples before the onset, mark_onset(), push() from the onset
/// on, then end_trial() (the trial counts) or discard_trial() (it does not, and leaves no trace). estimate()
/// may be asked for after any sample. With the natural frequency given in the options, or once it has been
/// tuned at a trial's end, the estimate after end_trial() equals identify(trials()) bit for bit: both sum the
/// same rows in the same order through the same filter. Until the first trial has ended a frequency that is
/// not given is kProvisionalFrequency.
///
/// Realtime: push_rest(), mark_onset() and push() allocate nothing; mark_onset() filters the rest kept
/// (Preparation::rest) in one go. The others allocate. Not thread-safe.
class StreamingIdentifier {
 public:
  /// Hz, of (8), until the data have been seen.
  static constexpr double kProvisionalFrequency = 2.0;

  /// Errors (kInvalidArgument): options or preparation out of limits, another method, or a model that needs
  /// more than the filter's states ((14), (15)). `longest_trial` (s, from the onset) bounds what is kept of a
  /// trial.
  [[nodiscard]] static Result<StreamingIdentifier> create(const Options& options,
                                                          const Preparation& preparation,
                                                          double longest_trial = 5.0);

  StreamingIdentifier(StreamingIdentifier&&) noexcept;
  StreamingIdentifier& operator=(StreamingIdentifier&&) noexcept;
  ~StreamingIdentifier();

  /// Starts a trial; one that is under way is discarded.
  void begin_trial(std::uint32_t number);
  void push_rest(const EndpointSample& sample);
  void mark_onset();
  void push(const EndpointSample& sample);
  /// Errors: as prepare_trial (a gap, no rest, a value that is not finite), or a number that was there before
  /// (kAlreadyExists); the trial is then discarded.
  [[nodiscard]] Result<void> end_trial();
  void discard_trial();

  /// A trial that had ended does not count any more: what follows is as if it had never been there. The trial
  /// under way goes on. False: there is no such trial. Allocates.
  bool remove_trial(std::uint32_t number);

  /// From all trials ended and the one under way so far; no trace; the data are diagnosed at each trial's
  /// end. The number of independent units includes the trial under way.
  [[nodiscard]] Estimate estimate() const;

  /// The full result: identify(trials(), options).
  [[nodiscard]] Result<Estimate> finish() const;

  /// The trials that count, in the order in which they ended.
  [[nodiscard]] std::span<const Trial> trials() const;

  /// Hz, of (8), in use now.
  [[nodiscard]] double natural_frequency() const;

  /// Samples that came after longest_trial, or before begin_trial, and were not kept.
  [[nodiscard]] std::size_t dropped() const;

 private:
  class Core;
  template <int kAxes, int kRegressors>
  class SizedCore;
  explicit StreamingIdentifier(std::unique_ptr<Core> core);
  std::unique_ptr<Core> core_;
};

}  // namespace tonus::impedance

#pragma once

#include <span>
#include <vector>

#include "services/core/result.hpp"

/// What an electromyogram says of a muscle's activity. Equations (1) to (8): this folder's README.
namespace tonus::muscles {

/// Edges of the filters, Hz.
struct EmgOptions {
  double low = 20.0;      ///< Of the band.
  double high = 450.0;    ///< Likewise; at most `most_of_nyquist` of half the rate.
  double envelope = 6.0;  ///< Of the envelope's low-pass.
  double most_of_nyquist = 0.9;
};

/// A stretch of a signal, s after its first value, [from, to).
struct Window {
  double from = 0.0;
  double to = 0.0;
};

/// Band-passed and rectified EMG (1)-(3), in the unit of `values`; NaN where the value was not measured. The
/// band-pass is causal: nothing of what follows an instant shows before it. kInvalidArgument: a rate (Hz)
/// whose half leaves no band.
[[nodiscard]] Result<std::vector<double>> rectified_emg(std::span<const float> values, double rate,
                                                        const EmgOptions& options = {});

/// The envelope (4) of a rectified EMG, without delay: the low-pass runs forward and backward. Values that
/// were not measured count as 0. Of fewer than 10 values, the values themselves.
[[nodiscard]] std::vector<double> envelope_of(std::span<const double> rectified, double rate,
                                              const EmgOptions& options = {});

/// Mean of a rectified EMG over a window (5). NaN where the window reaches beyond the signal or more than
/// half of its values were not measured.
[[nodiscard]] double mean_activity(std::span<const double> rectified, double rate, const Window& window);

/// The level of a reference contraction (6): the largest mean over 0.5 s. NaN where there are none.
[[nodiscard]] double reference_level(std::span<const double> rectified, double rate);

/// Index of co-contraction of two antagonists (7), 0 to 1, over envelopes that are normalised to reference
/// contractions. NaN where both are silent or their lengths differ.
[[nodiscard]] double co_contraction(std::span<const double> first, std::span<const double> second);

/// When a response to an onset begins (8), s after it: the instant at which the variance of band-passed EMG
/// rises with the largest likelihood, pooled over trials; then the same in the beginning of the response
/// alone, so that a gradual one is not found late. Of the simulated subject's reflexes, gradual ones
/// included, 478 of 480 are within 2 ms, the others within 3 ms. `squares` are sums of squared (or squared
/// rectified) values of `trials` trials at each instant; value `onset` is that of the onset. Looked for
/// between 10 ms and `latest` s. NaN: no change that is beyond chance.
[[nodiscard]] double response_latency(std::span<const double> squares, std::size_t trials, std::size_t onset,
                                      double rate, double latest = 0.1);

}  // namespace tonus::muscles

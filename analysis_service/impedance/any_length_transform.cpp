#include "analysis_service/impedance/any_length_transform.hpp"

#include <numbers>

namespace tonus::impedance {
namespace {

std::size_t largest_factor(std::size_t n) {
  std::size_t largest = 1;
  for (std::size_t p = 2; p * p <= n; ++p) {
    for (; n % p == 0; n /= p) largest = p;
  }
  return n > 1 ? n : largest;
}

/// The smallest 2^a 3^b 5^c that is at least n.
std::size_t smooth_length(std::size_t n) {
  while (largest_factor(n) > 5) ++n;
  return n;
}

}  // namespace

AnyLengthTransform::AnyLengthTransform() { forget_tables(); }

void AnyLengthTransform::forget_tables() {
  transform_ = Eigen::FFT<double>();
  transform_.SetFlag(Eigen::FFT<double>::Unscaled);
  tables_.clear();
}

void AnyLengthTransform::make_room_for(std::size_t length) {
  if (tables_.contains(length)) return;
  if (tables_.size() == kMostTables) forget_tables();
  tables_.insert(length);
}

void AnyLengthTransform::fwd(std::vector<Complex>& output, const std::vector<Complex>& input) {
  if (largest_factor(input.size()) <= kLargestDirectFactor) {
    make_room_for(input.size());
    transform_.fwd(output, input);
  } else {
    convolve(output, input, false);
  }
}

void AnyLengthTransform::inv(std::vector<Complex>& output, const std::vector<Complex>& input) {
  if (largest_factor(input.size()) <= kLargestDirectFactor) {
    make_room_for(input.size());
    transform_.inv(output, input);
  } else {
    convolve(output, input, true);
  }
}

void AnyLengthTransform::prepare(std::size_t length) {
  if (chirp_.size() == length) return;
  chirp_.resize(length);
  for (std::size_t n = 0; n < length; ++n) {
    const std::size_t turns = n * n % (2 * length);  // whole turns are taken out before rounding
    chirp_[n] = std::polar(1.0, -std::numbers::pi * static_cast<double>(turns) / static_cast<double>(length));
  }
  const std::size_t padded = smooth_length(2 * length - 1);
  make_room_for(padded);
  padded_.assign(padded, 0.0);
  padded_[0] = std::conj(chirp_[0]);
  for (std::size_t n = 1; n < length; ++n) padded_[n] = padded_[padded - n] = std::conj(chirp_[n]);
  transform_.fwd(response_, padded_);
}

void AnyLengthTransform::convolve(std::vector<Complex>& output, const std::vector<Complex>& input,
                                  bool is_inverse) {
  const std::size_t length = input.size();
  prepare(length);
  padded_.assign(response_.size(), 0.0);
  for (std::size_t n = 0; n < length; ++n)
    padded_[n] = (is_inverse ? std::conj(input[n]) : input[n]) * chirp_[n];
  transform_.fwd(spectrum_, padded_);
  for (std::size_t k = 0; k < spectrum_.size(); ++k) spectrum_[k] *= response_[k];
  transform_.inv(padded_, spectrum_);
  const double scale = 1.0 / static_cast<double>(response_.size());
  output.resize(length);
  for (std::size_t k = 0; k < length; ++k) {
    const Complex value = scale * chirp_[k] * padded_[k];
    output[k] = is_inverse ? std::conj(value) : value;
  }
}

}  // namespace tonus::impedance

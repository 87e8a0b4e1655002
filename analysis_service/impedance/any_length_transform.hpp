#pragma once

#include <complex>
#include <unsupported/Eigen/FFT>
#include <vector>

namespace tonus::impedance {

/// Discrete Fourier transform, unscaled both ways, of any length n in O(n log n).
///
/// Lengths whose largest prime factor is at most kLargestDirectFactor are transformed as they are. For others
/// the library takes O(n p) with p that factor, up to n^2; they go by Bluestein's convolution with a chirp,
/// X_k = c_k sum_n (x_n c_n) conj(c_(k-n)), c_n = exp(-i pi n^2 / N), at a length that is a power of 2. The
/// chirp is kept for the next signal of the same length. Not thread-safe.
class AnyLengthTransform {
 public:
  using Complex = std::complex<double>;
  static constexpr std::size_t kLargestDirectFactor = 50;

  AnyLengthTransform();

  /// sum_n x_n exp(-2 pi i k n / N). `input` and `output` are different vectors.
  void fwd(std::vector<Complex>& output, const std::vector<Complex>& input);
  /// sum_k x_k exp(+2 pi i k n / N).
  void inv(std::vector<Complex>& output, const std::vector<Complex>& input);

 private:
  void prepare(std::size_t length);
  void convolve(std::vector<Complex>& output, const std::vector<Complex>& input, bool is_inverse);

  Eigen::FFT<double> transform_;
  std::vector<Complex> chirp_;     // c_n
  std::vector<Complex> response_;  // transform of conj(c), at the padded length
  std::vector<Complex> padded_;
  std::vector<Complex> spectrum_;
};

}  // namespace tonus::impedance

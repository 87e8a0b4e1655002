#pragma once

#include <complex>
#include <set>
#include <unsupported/Eigen/FFT>
#include <vector>

namespace tonus::impedance {

/// Discrete Fourier transform, unscaled both ways, of any length n in O(n log n).
///
/// Lengths whose largest prime factor is at most kLargestDirectFactor are transformed as they are. For others
/// the library takes O(n p) with p that factor, up to n^2; they go by Bluestein's convolution with a chirp,
/// X_k = c_k sum_n (x_n c_n) conj(c_(k-n)), c_n = exp(-i pi n^2 / N), at a length whose prime factors are 2,
/// 3 and 5. The chirp is kept for the next signal of the same length, and the library's tables for the last
/// kMostTables lengths at most. Not thread-safe.
class AnyLengthTransform {
 public:
  using Complex = std::complex<double>;
  static constexpr std::size_t kLargestDirectFactor = 11;
  static constexpr std::size_t kMostTables = 64;

  AnyLengthTransform();

  /// sum_n x_n exp(-2 pi i k n / N). `input` and `output` are different vectors.
  void fwd(std::vector<Complex>& output, const std::vector<Complex>& input);
  /// sum_k x_k exp(+2 pi i k n / N).
  void inv(std::vector<Complex>& output, const std::vector<Complex>& input);

 private:
  void forget_tables();
  void make_room_for(std::size_t length);
  void prepare(std::size_t length);
  void convolve(std::vector<Complex>& output, const std::vector<Complex>& input, bool is_inverse);

  Eigen::FFT<double> transform_;
  std::set<std::size_t> tables_;   // lengths that transform_ has tables of
  std::vector<Complex> chirp_;     // c_n
  std::vector<Complex> response_;  // transform of conj(c), at the padded length
  std::vector<Complex> padded_;
  std::vector<Complex> spectrum_;
};

}  // namespace tonus::impedance

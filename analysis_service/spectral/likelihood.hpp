#pragma once

#include <Eigen/Core>
#include <array>
#include <complex>
#include <vector>

namespace tonus::spectral {

/// Negative logarithm of the likelihood of windowed spectra under errors in both signals (equation 7), of N
/// axes, and its gradient in closed form.
///
/// Parameters: M, B, K row by row (N^2 each), the lag d of each force (N), then for each axis a0, a1, b0, b1
/// of the noises' power laws nx = exp(a0 + a1 ln w), nf = exp(b0 + b1 ln w). All in scaled units: w and the
/// spectra about 1. Moments: sum over the segments of Y Y^H, Y = (F, X2, X1, X0). Pure, no allocation but for
/// what is returned.
template <int N>
class Likelihood {
 public:
  static constexpr int kImpedance = 3 * N * N;        ///< Elements of M, B, K.
  static constexpr int kStructural = kImpedance + N;  ///< And the lags.
  static constexpr int kParameters = kStructural + 4 * N;
  using Complex = std::complex<double>;
  using Vector = Eigen::Matrix<double, kParameters, 1>;
  using Hessian = Eigen::MatrixXd;  ///< kParameters square; sized at run time: it compiles in seconds.
  using Square = Eigen::Matrix<Complex, N, N>;
  using Moment = Eigen::Matrix<Complex, 4 * N, 4 * N>;
  using Diagonal = Eigen::Matrix<double, N, 1>;

  /// Moments by bin and how many segments they are of.
  struct Data {
    std::vector<Moment> moments;
    double segments = 0.0;
  };

  /// `weight`: independent segments of one bin.
  Likelihood(Eigen::ArrayXd w, double weight) : w_(std::move(w)), log_w_(w_.log()), weight_(weight) {}

  /// A wide prior on the noise laws, centred at these values: a noise that is absent leaves its law free.
  void centre_noise(const Vector& parameters) {
    centre_ = parameters;
    has_centre_ = true;
  }

  [[nodiscard]] Eigen::Index bins() const { return w_.size(); }
  [[nodiscard]] const Eigen::ArrayXd& w() const { return w_; }

  [[nodiscard]] double value(const Vector& p, const Data& data) const;
  /// Over bins [first, end), without the prior unless they are all.
  [[nodiscard]] Vector gradient(const Vector& p, const Data& data, Eigen::Index first,
                                Eigen::Index end) const;
  [[nodiscard]] Vector gradient(const Vector& p, const Data& data) const {
    return gradient(p, data, 0, bins());
  }
  /// By differences of the gradient, symmetric.
  [[nodiscard]] Hessian hessian(const Vector& p, const Data& data) const;

  /// What one bin gives.
  struct Bin {
    Square Z;  ///< K + jwB - w^2 M.
    Square N_inverse;
    Square noise;  ///< N = nf + Z nx Z^H.
    Diagonal nx;
    Diagonal nf;
    Square RR;                            ///< <R R^H>.
    Square RX;                            ///< <R X0^H>.
    Square XX;                            ///< <X0 X0^H>.
    Eigen::Matrix<Complex, N, 4 * N> A;   ///< R = A Y.
    Eigen::Matrix<Complex, N, 4 * N> AG;  ///< A <Y Y^H>.
  };
  [[nodiscard]] Bin bin(const Vector& p, const Data& data, Eigen::Index k) const;

 private:
  Eigen::ArrayXd w_;
  Eigen::ArrayXd log_w_;
  double weight_;
  Vector centre_ = Vector::Zero();
  bool has_centre_ = false;
};

extern template class Likelihood<1>;
extern template class Likelihood<2>;

}  // namespace tonus::spectral

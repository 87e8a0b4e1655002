#pragma once

#include <array>
#include <cstddef>

/// Tables of Dolan, Friedman & Nagurka (1993), as printed. "sd" is one standard deviation.
namespace tonus::report::published {

struct Value {
  double value = 0.0;
  double sd = 0.0;
};

/// Table I: link masses, kg, of three subjects by the three methods (low-pass, optimal, state variable).
struct TableOneRow {
  std::array<Value, 3> upper_arm;
  std::array<Value, 3> forearm;
};
inline constexpr std::array<TableOneRow, 3> kTableOne{{
    {{{{1.80, 0.45}, {1.74, 0.38}, {2.47, 0.36}}}, {{{1.56, 0.13}, {1.49, 0.11}, {1.54, 0.10}}}},
    {{{{1.58, 0.69}, {1.61, 0.47}, {2.19, 0.53}}}, {{{1.74, 0.20}, {1.74, 0.13}, {1.58, 0.15}}}},
    {{{{0.92, 0.47}, {1.08, 0.85}, {1.36, 0.61}}}, {{{1.36, 0.13}, {1.28, 0.24}, {1.23, 0.17}}}},
}};

/// Table II: average fitting errors sigma_1, sigma_2, N, of models (3), (13), (14), (15) at reference,
/// distal, proximal, right, left; two subjects.
using Pair = std::array<double, 2>;
using TableTwo = std::array<std::array<Pair, 4>, 5>;
inline constexpr std::array<TableTwo, 2> kTableTwo{{
    {{{{{0.21, 0.34}, {0.28, 0.53}, {0.28, 0.53}, {0.21, 0.35}}},
      {{{0.23, 0.56}, {0.28, 0.73}, {0.28, 0.73}, {0.23, 0.51}}},
      {{{0.33, 0.82}, {0.47, 0.99}, {0.47, 0.99}, {0.33, 0.84}}},
      {{{0.32, 0.45}, {0.37, 0.64}, {0.37, 0.64}, {0.32, 0.51}}},
      {{{0.27, 0.34}, {0.43, 0.53}, {0.43, 0.51}, {0.34, 0.42}}}}},
    {{{{{0.36, 0.48}, {0.39, 0.54}, {0.38, 0.53}, {0.35, 0.48}}},
      {{{0.27, 0.66}, {0.29, 0.74}, {0.29, 0.73}, {0.27, 0.65}}},
      {{{0.41, 0.53}, {0.46, 0.58}, {0.45, 0.58}, {0.40, 0.55}}},
      {{{0.30, 0.50}, {0.36, 0.59}, {0.36, 0.58}, {0.31, 0.50}}},
      {{{0.40, 0.29}, {0.48, 0.42}, {0.48, 0.41}, {0.43, 0.32}}}}},
}};
inline constexpr std::array<const char*, 5> kTableTwoPostures{"reference", "distal", "proximal", "right",
                                                              "left"};

/// Table III: tau (s) with its % error, zeta with its; eleven subjects.
struct TableThreeRow {
  Value tau;
  double tau_error = 0.0;
  Value zeta;
  double zeta_error = 0.0;
};
inline constexpr std::array<TableThreeRow, 11> kTableThree{{
    {{0.056, 0.007}, 20, {0.25, 0.02}, 13},
    {{0.057, 0.005}, 14, {0.25, 0.01}, 9},
    {{0.026, 0.005}, 31, {0.17, 0.02}, 25},
    {{0.068, 0.007}, 17, {0.27, 0.02}, 13},
    {{0.151, 0.013}, 17, {0.51, 0.03}, 12},
    {{0.227, 0.030}, 27, {0.62, 0.07}, 22},
    {{0.071, 0.007}, 20, {0.23, 0.03}, 25},
    {{0.026, 0.006}, 34, {0.14, 0.04}, 34},
    {{0.077, 0.008}, 20, {0.25, 0.02}, 18},
    {{0.025, 0.006}, 35, {0.12, 0.02}, 29},
    {{0.011, 0.002}, 30, {0.08, 0.01}, 29},
}};

/// Table IV: shoulder, elbow, two-joint; tau in s.
struct TableFourRow {
  std::array<double, 3> tau{};
  double tau_error = 0.0;
  std::array<double, 3> zeta{};
  double zeta_error = 0.0;
};
inline constexpr std::array<TableFourRow, 11> kTableFour{{
    {{0.067, 0.040, 0.039}, 17, {0.254, 0.261, 0.176}, 12},
    {{0.062, 0.046, 0.021}, 11, {0.252, 0.284, 0.104}, 7},
    {{0.037, 0.013, 0.012}, 21, {0.186, 0.097, 0.063}, 19},
    {{0.082, 0.050, 0.045}, 13, {0.272, 0.295, 0.196}, 12},
    {{0.178, 0.108, 0.078}, 10, {0.507, 0.553, 0.243}, 9},
    {{0.246, 0.214, 0.177}, 25, {0.582, 0.977, 0.512}, 17},
    {{0.067, 0.082, 0.053}, 20, {0.201, 0.427, 0.143}, 17},
    {{0.019, 0.042, 0.010}, 30, {0.105, 0.402, 0.067}, 22},
    {{0.087, 0.069, 0.027}, 18, {0.249, 0.349, 0.089}, 15},
    {{0.030, 0.020, 0.004}, 33, {0.127, 0.135, 0.015}, 27},
    {{0.010, 0.013, 0.008}, 29, {0.067, 0.139, 0.063}, 23},
}};

}  // namespace tonus::report::published

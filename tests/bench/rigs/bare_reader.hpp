#pragma once

#include <string>
#include <vector>

#include "services/bus/partitions.hpp"

/// The yardstick of many rigs: a program that takes every block of samples and answers it at once by as many
/// bytes as an estimate has, and does nothing else.
namespace tonus::bench {

inline constexpr char kAnswers[] = "bench-answers";  ///< Partition of what it answers.
inline constexpr std::size_t kNumberAt = 20;         ///< In an answer: the block's first number.

[[nodiscard]] bus::TopicSpec answer_topic();

/// Until it is killed; 1 where the bus cannot be opened.
[[nodiscard]] int answer_every_block(const bus::BusOptions& options, const std::vector<std::string>& rigs);

}  // namespace tonus::bench

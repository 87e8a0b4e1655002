#pragma once

#include <cstdint>
#include <list>
#include <map>
#include <memory>
#include <vector>

#include "services/bus/bus.hpp"

namespace tonus::dashboard {

/// The JSON of a message, made when it is first asked for, for all who pass it on; null: it cannot be read.
struct JsonBody {
  bool is_made = false;
  std::shared_ptr<const bus::Payload> text;
};

/// A message as it is passed on.
struct PassedMessage {
  std::uint32_t channel = 0;
  bus::Key key{};
  std::uint64_t time_ns = 0;  ///< When it was written, UTC.
  std::shared_ptr<const bus::Payload> payload;
  std::shared_ptr<JsonBody> json = std::make_shared<JsonBody>();  ///< Shared by its copies.
};

/// The newest message of each key of each kept topic, for late joiners. Bounded per topic, by number and by
/// bytes: the one that has not changed for longest gives way, and is counted.
class LatestValues {
 public:
  struct Limits {
    std::size_t messages = 4096;
    std::size_t bytes = std::size_t{8} << 20;
  };

  explicit LatestValues(Limits limits) : limits_(limits) {}

  void put(const PassedMessage& message);

  /// Of one topic, in the order of their coming.
  [[nodiscard]] std::vector<PassedMessage> of(std::uint32_t channel) const;

  [[nodiscard]] std::size_t messages() const;
  [[nodiscard]] std::size_t bytes() const;
  [[nodiscard]] std::uint64_t forgotten() const { return forgotten_; }

 private:
  struct Topic {
    std::list<PassedMessage> in_order;
    std::map<bus::Key, std::list<PassedMessage>::iterator> by_key;
    std::size_t bytes = 0;
  };
  Limits limits_;
  std::map<std::uint32_t, Topic> topics_;
  std::uint64_t forgotten_ = 0;
};

}  // namespace tonus::dashboard

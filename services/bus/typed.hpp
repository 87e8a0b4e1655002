#pragma once

#include <chrono>
#include <concepts>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "services/bus/bus.hpp"

namespace eprosima::fastcdr {
class Cdr;
}

/// Typed access to the bus, for the types that fastddsgen generates; serialised by Fast CDR. Generated types
/// do not check their own bounds: where a function `std::string bounds_violation(const T&)` is found beside
/// the type, it is asked before sending and after receiving, and a non-empty answer (what is out of bounds,
/// its value and the limit) refuses the message.
namespace tonus::bus {

/// A topic and the type that it carries.
template <typename T>
struct Topic {
  TopicSpec spec;
};

namespace detail {

/// Header, members, zeros to a multiple of four. `member_bytes` is what `serialize` writes; anything else is
/// refused (a string with a zero byte inside would be cut short).
[[nodiscard]] Result<Payload> encode_members(std::size_t member_bytes, const void* value,
                                             void (*serialize)(const void* value, eprosima::fastcdr::Cdr&));

/// Runs `deserialize` over the members; the number of bytes that it read. Converts every exception.
[[nodiscard]] Result<std::size_t> decode_members(std::span<const std::byte> payload, void* value,
                                                 void (*deserialize)(void* value, eprosima::fastcdr::Cdr&));

/// kInvalidArgument unless the members read are the value's own size and fill the payload up to padding.
[[nodiscard]] Result<void> check_extent(std::size_t payload_bytes, std::size_t read_bytes,
                                        std::size_t value_bytes);

template <typename T>
concept Bounded = requires(const T& value) {
  { bounds_violation(value) } -> std::convertible_to<std::string>;
};

template <typename T>
[[nodiscard]] Result<void> check_bounds(const T& value) {
  if constexpr (Bounded<T>) {
    if (std::string violation = bounds_violation(value); !violation.empty()) {
      return fail(ErrorCode::kInvalidArgument, std::move(violation));
    }
  }
  return {};
}

}  // namespace detail

/// kInvalidArgument when a bound is passed. Strings must not hold a zero byte: the generated code cuts them
/// there.
template <typename T>
[[nodiscard]] Result<Payload> encode(const T& value) {
  if (auto within = detail::check_bounds(value); !within) return within.error();
  return detail::encode_members(
      T::getCdrSerializedSize(value), &value,
      [](const void* source, eprosima::fastcdr::Cdr& cdr) { static_cast<const T*>(source)->serialize(cdr); });
}

/// kInvalidArgument for anything that is not exactly one value of T within its bounds, padded to four. Never
/// throws, and allocates no more than a small multiple of the payload.
template <typename T>
[[nodiscard]] Result<T> decode(std::span<const std::byte> payload) {
  T value;
  const auto read = detail::decode_members(payload, &value, [](void* target, eprosima::fastcdr::Cdr& cdr) {
    static_cast<T*>(target)->deserialize(cdr);
  });
  if (!read) return read.error();
  if (auto extent = detail::check_extent(payload.size(), *read, T::getCdrSerializedSize(value)); !extent) {
    return extent.error();
  }
  if (auto within = detail::check_bounds(value); !within) return within.error();
  return value;
}

/// A Writer of one type.
template <typename T>
class TypedWriter {
 public:
  explicit TypedWriter(std::unique_ptr<Writer> writer) : writer_(std::move(writer)) {}

  [[nodiscard]] static Result<TypedWriter> create(Bus& bus, const Topic<T>& topic) {
    auto writer = bus.create_writer(topic.spec);
    if (!writer) return writer.error();
    return TypedWriter(std::move(*writer));
  }

  /// As Writer::write, and the errors of encode.
  [[nodiscard]] Result<void> write(const T& value) {
    const auto payload = encode(value);
    if (!payload) return payload.error();
    return writer_->write(*payload);
  }

  [[nodiscard]] WriterStatus status() const { return writer_->status(); }
  bool wait_acknowledged(std::chrono::milliseconds limit) { return writer_->wait_acknowledged(limit); }

 private:
  std::unique_ptr<Writer> writer_;
};

template <typename T>
struct Received {
  T value;
  Sample sample;  ///< As it came: bytes, key and stamps.
};

/// A Reader of one type. A payload that does not decode is counted as malformed and left out. For one thread.
template <typename T>
class TypedReader {
 public:
  explicit TypedReader(std::unique_ptr<Reader> reader) : reader_(std::move(reader)) {}

  [[nodiscard]] static Result<TypedReader> create(Bus& bus, const Topic<T>& topic,
                                                  const std::shared_ptr<Notifier>& notifier) {
    auto reader = bus.create_reader(topic.spec, notifier);
    if (!reader) return reader.error();
    return TypedReader(std::move(*reader));
  }

  /// Appends what has arrived, takes at most `max` samples, and returns how many were appended. Can be 0 with
  /// more to come only when all that it took was malformed.
  std::size_t take(std::vector<Received<T>>& out, std::size_t max = 256) {
    samples_.clear();
    reader_->take(samples_, max);
    std::size_t appended = 0;
    for (Sample& sample : samples_) {
      auto value = decode<T>(*sample.payload);
      if (!value) {
        ++undecodable_;
        continue;
      }
      out.push_back({std::move(*value), std::move(sample)});
      ++appended;
    }
    return appended;
  }

  [[nodiscard]] ReaderStatus status() const {
    ReaderStatus status = reader_->status();
    status.received -= undecodable_;
    status.malformed += undecodable_;
    return status;
  }

 private:
  std::unique_ptr<Reader> reader_;
  std::vector<Sample> samples_;
  std::uint64_t undecodable_ = 0;
};

}  // namespace tonus::bus

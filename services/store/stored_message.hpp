#pragma once

#include <fastcdr/Cdr.h>

#include "idl/bounded_read.hpp"
#include "idl/bounds.hpp"
#include "services/bus/typed.hpp"

namespace tonus::store {

/// As bus::decode(), of a message that is in an archive: its texts that are not UTF-8 are masked. On the bus
/// such a message is refused; here that would lose what it says.
template <typename T>
[[nodiscard]] Result<T> decode_stored(std::span<const std::byte> payload) {
  T value;
  TONUS_TRY_ASSIGN(const auto read, bus::detail::decode_members(
                                        payload, &value, [](void* target, eprosima::fastcdr::Cdr& cdr) {
                                          v1::repair_texts(cdr);
                                          static_cast<T*>(target)->deserialize(cdr);
                                        }));
  TONUS_TRY(bus::detail::check_extent(payload.size(), read, T::getCdrSerializedSize(value)));
  TONUS_TRY(bus::detail::check_bounds(value));
  return value;
}

}  // namespace tonus::store

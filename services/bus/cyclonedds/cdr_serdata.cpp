#include "services/bus/cyclonedds/cdr_serdata.hpp"

#include <algorithm>
#include <cstdio>
#include <cstring>
#include <dds/ddsi/q_radmin.h>
#include <utility>

#include "services/bus/cyclonedds/cdr_sertype.hpp"
#include "services/bus/payload.hpp"

namespace tonus::bus {
namespace {

const CdrSerdata& as_cdr(const ddsi_serdata* data) { return *static_cast<const CdrSerdata*>(data); }

std::uint32_t hash_of(const Key& key) {
  std::uint32_t hash = 2166136261U;  // FNV-1a
  for (const std::uint8_t byte : key) hash = (hash ^ byte) * 16777619U;
  return hash;
}

/// A serdata of what came from the network; null where memory is short, which Cyclone takes as a refusal.
ddsi_serdata* received(const ddsi_sertype* type, ddsi_serdata_kind kind, Payload&& bytes) {
  auto* data = new CdrSerdata(type, kind, std::make_shared<const Payload>(std::move(bytes)));
  data->arrival = static_cast<const CdrSertype*>(type)->next_arrival();
  data->received_ns = std::chrono::duration_cast<std::chrono::nanoseconds>(
                          std::chrono::steady_clock::now().time_since_epoch())
                          .count();
  return data;
}

/// C callers know no exceptions.
template <typename Action>
ddsi_serdata* null_on_exception(const Action& action) noexcept {
  try {
    return action();
  } catch (...) {
    return nullptr;
  }
}

Payload key_payload(const Key& key) {
  Payload bytes(kMinimumPayloadBytes, std::byte{0});
  bytes[1] = std::byte{1};
  std::memcpy(bytes.data() + kEncapsulationBytes, key.data(), key.size());
  return bytes;
}

/// A malformed sample is let through with a key of zeros, so that the reader can count it; a malformed key is
/// not.
ddsi_serdata* from_ser(const ddsi_sertype* type, ddsi_serdata_kind kind, const nn_rdata* fragment,
                       std::size_t size) {
  return null_on_exception([&]() -> ddsi_serdata* {
    if (kind == SDK_KEY && size < kMinimumPayloadBytes) return nullptr;
    Payload bytes(padded_to_four(size), std::byte{0});
    std::size_t filled = 0;
    for (; fragment != nullptr; fragment = fragment->nextfrag) {
      if (fragment->maxp1 <= filled) continue;  // fragments may overlap
      const unsigned char* data = NN_RMSG_PAYLOADOFF(fragment->rmsg, NN_RDATA_PAYLOAD_OFF(fragment));
      const std::size_t end = std::min<std::size_t>(fragment->maxp1, size);
      std::memcpy(bytes.data() + filled, data + (filled - fragment->min), end - filled);
      filled = end;
    }
    return received(type, kind, std::move(bytes));
  });
}

ddsi_serdata* from_ser_iov(const ddsi_sertype* type, ddsi_serdata_kind kind, ddsrt_msg_iovlen_t count,
                           const ddsrt_iovec_t* parts, std::size_t size) {
  return null_on_exception([&]() -> ddsi_serdata* {
    if (kind == SDK_KEY && size < kMinimumPayloadBytes) return nullptr;
    Payload bytes(padded_to_four(size), std::byte{0});
    std::size_t filled = 0;
    for (ddsrt_msg_iovlen_t i = 0; i < count && filled < size; ++i) {
      const std::size_t part = std::min<std::size_t>(parts[i].iov_len, size - filled);
      std::memcpy(bytes.data() + filled, parts[i].iov_base, part);
      filled += part;
    }
    return received(type, kind, std::move(bytes));
  });
}

ddsi_serdata* from_key(const ddsi_sertype* type, const Key& key) {
  return null_on_exception(
      [&] { return new CdrSerdata(type, SDK_KEY, std::make_shared<const Payload>(key_payload(key))); });
}

ddsi_serdata* from_keyhash(const ddsi_sertype* type, const ddsi_keyhash* keyhash) {
  Key key;
  std::copy(std::begin(keyhash->value), std::end(keyhash->value), key.begin());
  return from_key(type, key);
}

ddsi_serdata* to_untyped(const ddsi_serdata* data) {
  ddsi_serdata* untyped = from_key(data->type, as_cdr(data).key);
  if (untyped == nullptr) return nullptr;
  untyped->hash = data->hash;
  untyped->type = nullptr;
  return untyped;
}

bool has_equal_key(const ddsi_serdata* a, const ddsi_serdata* b) { return as_cdr(a).key == as_cdr(b).key; }

std::uint32_t size_of(const ddsi_serdata* data) {
  return static_cast<std::uint32_t>(as_cdr(data).payload->size());
}

void to_ser(const ddsi_serdata* data, std::size_t offset, std::size_t size, void* out) {
  std::memcpy(out, as_cdr(data).payload->data() + offset, size);
}

ddsi_serdata* to_ser_ref(const ddsi_serdata* data, std::size_t offset, std::size_t size,
                         ddsrt_iovec_t* part) {
  part->iov_base = const_cast<std::byte*>(as_cdr(data).payload->data() + offset);  // Cyclone only reads it
  part->iov_len = static_cast<ddsrt_iov_len_t>(size);
  return ddsi_serdata_ref(data);
}

void to_ser_unref(ddsi_serdata* data, const ddsrt_iovec_t* /*part*/) { ddsi_serdata_unref(data); }

void free_serdata(ddsi_serdata* data) { delete static_cast<CdrSerdata*>(data); }

std::size_t print(const ddsi_sertype* /*type*/, const ddsi_serdata* data, char* out, std::size_t size) {
  return static_cast<std::size_t>(std::snprintf(out, size, "(cdr, %zu bytes)", as_cdr(data).payload->size()));
}

void get_keyhash(const ddsi_serdata* data, ddsi_keyhash* out, bool /*force_md5*/) {
  std::copy(as_cdr(data).key.begin(), as_cdr(data).key.end(), std::begin(out->value));
}

// The calls that take application samples (dds_write, dds_take) do not exist for bytes and fail.
ddsi_serdata* from_sample(const ddsi_sertype*, ddsi_serdata_kind, const void*) { return nullptr; }
bool to_sample(const ddsi_serdata*, void*, void**, void*) { return false; }
bool untyped_to_sample(const ddsi_sertype*, const ddsi_serdata*, void*, void**, void*) { return false; }

ddsi_serdata_ops make_ops() {
  ddsi_serdata_ops ops{};
  ops.eqkey = has_equal_key;
  ops.get_size = size_of;
  ops.from_ser = from_ser;
  ops.from_ser_iov = from_ser_iov;
  ops.from_keyhash = from_keyhash;
  ops.from_sample = from_sample;
  ops.to_ser = to_ser;
  ops.to_ser_ref = to_ser_ref;
  ops.to_ser_unref = to_ser_unref;
  ops.to_sample = to_sample;
  ops.to_untyped = to_untyped;
  ops.untyped_to_sample = untyped_to_sample;
  ops.free = free_serdata;
  ops.print = print;
  ops.get_keyhash = get_keyhash;
  return ops;
}

}  // namespace

void HeldPayloads::add() {
  const std::lock_guard lock(mutex_);
  ++count_;
}

void HeldPayloads::remove() {
  const std::lock_guard lock(mutex_);
  --count_;
  removed_.notify_all();
}

bool HeldPayloads::wait_below(std::size_t limit, std::chrono::milliseconds longest) {
  std::unique_lock lock(mutex_);
  return removed_.wait_for(lock, longest, [&] { return count_ < limit; });
}

CdrSerdata::CdrSerdata(const ddsi_sertype* sertype, ddsi_serdata_kind data_kind,
                       std::shared_ptr<const Payload> bytes)
    : ddsi_serdata{}, payload(std::move(bytes)), key(payload_key(*payload)) {
  ddsi_serdata_init(this, sertype, data_kind);
  hash = hash_of(key) ^ sertype->serdata_basehash;
}

CdrSerdata::~CdrSerdata() {
  if (held) held->remove();
}

const ddsi_serdata_ops* cdr_serdata_ops() {
  static const ddsi_serdata_ops ops = make_ops();
  return &ops;
}

}  // namespace tonus::bus

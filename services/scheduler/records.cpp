#include "services/scheduler/records.hpp"

#include <exception>
#include <fastcdr/Cdr.h>
#include <fastcdr/FastBuffer.h>
#include <fastcdr/exceptions/NotEnoughMemoryException.h>
#include <spdlog/fmt/fmt.h>
#include <type_traits>
#include <utility>

namespace tonus::scheduler {
namespace {

using eprosima::fastcdr::Cdr;
using eprosima::fastcdr::FastBuffer;

constexpr std::size_t kEncodedMost = 1U << 20;

/// Puts a field into a Cdr, or takes it out: one description of each record serves both ways.
class Put {
 public:
  explicit Put(Cdr& cdr) : cdr_(cdr) {}
  template <typename T>
  Put& operator&(const T& field) {
    if constexpr (std::is_enum_v<T>) {
      cdr_ << static_cast<std::uint32_t>(field);
    } else {
      cdr_ << field;
    }
    return *this;
  }

 private:
  Cdr& cdr_;
};

class Take {
 public:
  explicit Take(Cdr& cdr) : cdr_(cdr) {}
  template <typename T>
  Take& operator&(T& field) {
    if constexpr (std::is_enum_v<T>) {
      std::uint32_t number = 0;
      cdr_ >> number;
      field = static_cast<T>(number);
    } else {
      cdr_ >> field;
    }
    return *this;
  }

 private:
  Cdr& cdr_;
};

template <typename A, typename R>
void fields(A archive, R& r) {
  using T = std::remove_const_t<R>;
  if constexpr (std::is_same_v<T, record::Started>) {
    archive& r.session_id& r.request_id& r.protocol_toml& r.subject& r.seed& r.started_at& r
        .software_version& r.subject_facts& r.operator_name& r.study& r.is_pilot;
  } else if constexpr (std::is_same_v<T, record::Bound>) {
    archive& r.rig_id& r.home;
  } else if constexpr (std::is_same_v<T, record::Commanded>) {
    archive& r.program;
  } else if constexpr (std::is_same_v<T, record::Counted>) {
    archive& r.attempt& r.duration;
  } else if constexpr (std::is_same_v<T, record::Rejected>) {
    archive& r.attempt& r.place& r.owes_receipt& r.duration& r.reason& r.is_reviewed& r.reviewed_ns;
  } else if constexpr (std::is_same_v<T, record::Refused>) {
    archive& r.attempt& r.reason;
  } else if constexpr (std::is_same_v<T, record::Receipted>) {
    archive& r.attempt;
  } else if constexpr (std::is_same_v<T, record::AxesFixed>) {
    archive& r.posture_index& r.major& r.minor& r.stiffness;
  } else if constexpr (std::is_same_v<T, record::PostureConfirmed>) {
    archive& r.posture_index;
  } else if constexpr (std::is_same_v<T, record::LimitRaised>) {
    archive& r.block;
  } else if constexpr (std::is_same_v<T, record::Requested>) {
    archive& r.request_id& r.request;
  } else if constexpr (std::is_same_v<T, record::Answered>) {
    archive& r.request_id& r.is_done& r.message;
  } else if constexpr (std::is_same_v<T, record::Ended>) {
    archive& r.phase& r.message;
  } else if constexpr (std::is_same_v<T, record::Reviewed>) {
    archive& r.attempt& r.planned_index& r.place& r.reason& r.reviewed_by& r.reviewed_ns;
  } else if constexpr (std::is_same_v<T, record::Noted>) {
    archive& r.note_id& r.trial_id& r.kind& r.text& r.written_by& r.written_ns& r.has_rig_clock& r
        .rig_clock_ns& r.epoch;
  } else {
    static_assert(std::is_same_v<T, record::Looked>);
    archive& r.condition& r.newest& r.counted& r.estimate_id& r.trials& r.stiffness& r.mass& r.damping& r
        .is_ok& r.is_linear& r.end& r.needed& r.because& r.amplitude& r.rise_time;
  }
}

template <std::size_t I = 0>
Record take_record(Cdr& cdr, std::uint32_t type) {
  if constexpr (I < std::variant_size_v<Record>) {
    if (type != I) return take_record<I + 1>(cdr, type);
    std::variant_alternative_t<I, Record> value;
    fields(Take(cdr), value);
    return value;
  } else {
    throw std::out_of_range(fmt::format("record type {} is not allowed; expected 0 to {}", type, I - 1));
  }
}

}  // namespace

std::vector<protocol::Look> looks_of(const std::vector<record::Looked>& records) {
  std::vector<protocol::Look> looks;
  looks.reserve(records.size());
  for (const record::Looked& r : records)
    looks.push_back({r.trials, r.stiffness, r.mass, r.damping, r.is_ok, r.is_linear});
  return looks;
}

Result<std::string> encode_records(const std::vector<Record>& records) {
  // Into zeros of our own: the serialiser leaves the octets between aligned fields as they are.
  for (std::size_t size = 4096; size <= kEncodedMost; size *= 2) {
    std::string octets(size, '\0');
    FastBuffer buffer(octets.data(), octets.size());
    Cdr cdr(buffer, Cdr::LITTLE_ENDIANNESS, Cdr::CORBA_CDR);
    try {
      cdr << static_cast<std::uint32_t>(records.size());
      for (const Record& record : records) {
        cdr << static_cast<std::uint32_t>(record.index());
        std::visit([&cdr](const auto& r) { fields(Put(cdr), r); }, record);
      }
    } catch (const eprosima::fastcdr::exception::NotEnoughMemoryException&) {
      continue;
    }
    octets.resize(cdr.getSerializedDataLength());
    return octets;
  }
  return fail(ErrorCode::kInvalidArgument,
              fmt::format("journal records are longer than {} bytes", kEncodedMost));
}

Result<std::vector<Record>> decode_records(std::string_view octets) {
  std::string copy(octets);
  FastBuffer buffer(copy.data(), copy.size());
  Cdr cdr(buffer, Cdr::LITTLE_ENDIANNESS, Cdr::CORBA_CDR);
  std::vector<Record> records;
  try {
    std::uint32_t count = 0;
    cdr >> count;
    for (std::uint32_t i = 0; i < count; ++i) {
      std::uint32_t type = 0;
      cdr >> type;
      records.push_back(take_record(cdr, type));
    }
  } catch (const std::exception& error) {
    return fail(ErrorCode::kDataLoss, fmt::format("journal record cannot be read: {}", error.what()));
  }
  if (cdr.getSerializedDataLength() != copy.size()) {
    return fail(ErrorCode::kDataLoss, fmt::format("journal record of {} bytes was expected to have {}",
                                                  copy.size(), cdr.getSerializedDataLength()));
  }
  return records;
}

}  // namespace tonus::scheduler

#pragma once

#include <dds/dds.h>
#include <memory>

#include "services/bus/bus.hpp"

namespace tonus::bus {

struct CycloneQosDeleter {
  void operator()(dds_qos_t* qos) const { dds_delete_qos(qos); }
};

/// The bus's QoS in Cyclone DDS's terms.
class CycloneQos {
 public:
  CycloneQos() : qos_(dds_create_qos()) {}
  [[nodiscard]] static CycloneQos of_writer(const Qos& qos);
  [[nodiscard]] static CycloneQos of_reader(const Qos& qos);
  [[nodiscard]] dds_qos_t* get() const { return qos_.get(); }

 private:
  explicit CycloneQos(const Qos& qos);
  std::unique_ptr<dds_qos_t, CycloneQosDeleter> qos_;
};

[[nodiscard]] constexpr dds_duration_t cyclone_duration(std::chrono::milliseconds time) {
  return std::chrono::nanoseconds(time).count();
}

}  // namespace tonus::bus

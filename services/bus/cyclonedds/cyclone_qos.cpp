#include "services/bus/cyclonedds/cyclone_qos.hpp"

namespace tonus::bus {

CycloneQos::CycloneQos(const Qos& qos) : CycloneQos() {
  dds_qset_reliability(get(), qos.reliable ? DDS_RELIABILITY_RELIABLE : DDS_RELIABILITY_BEST_EFFORT,
                       cyclone_duration(qos.max_blocking));
  dds_qset_durability(get(), qos.durability == Durability::kTransientLocal ? DDS_DURABILITY_TRANSIENT_LOCAL
                                                                           : DDS_DURABILITY_VOLATILE);
  dds_qset_history(get(), qos.history == History::kKeepAll ? DDS_HISTORY_KEEP_ALL : DDS_HISTORY_KEEP_LAST,
                   qos.depth);
  const dds_data_representation_id_t representation = DDS_DATA_REPRESENTATION_XCDR1;
  dds_qset_data_representation(get(), 1, &representation);
  if (qos.deadline.count() > 0) dds_qset_deadline(get(), cyclone_duration(qos.deadline));
  if (qos.liveliness_lease.count() > 0) {
    dds_qset_liveliness(get(), DDS_LIVELINESS_AUTOMATIC, cyclone_duration(qos.liveliness_lease));
  }
}

CycloneQos CycloneQos::of_writer(const Qos& qos) {
  CycloneQos out(qos);
  dds_qset_writer_data_lifecycle(out.get(), false);  // leaving is not disposing
  // What is kept for late readers; unlimited by key, or memory would grow with every sample.
  dds_qset_durability_service(out.get(), 0, DDS_HISTORY_KEEP_LAST, qos.depth, DDS_LENGTH_UNLIMITED,
                              DDS_LENGTH_UNLIMITED, DDS_LENGTH_UNLIMITED);
  return out;
}

CycloneQos CycloneQos::of_reader(const Qos& qos) {
  CycloneQos out(qos);
  if (qos.history == History::kKeepAll) {
    dds_qset_resource_limits(out.get(), qos.depth, DDS_LENGTH_UNLIMITED, DDS_LENGTH_UNLIMITED);
  }
  return out;
}

}  // namespace tonus::bus

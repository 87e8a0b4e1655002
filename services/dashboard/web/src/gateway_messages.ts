// What the gateway itself says, as JSON: gateway/hub_status.cpp and gateway/operator_desk.cpp.

export interface GatewayStatus {
  utc_ns: number;
  clients: { id: number; peer: string; role: string; thinned: number; waiting_messages: number }[];
  thinned: number;
  arrival_drops: number;
}

export interface OperatorReply {
  request_id: string;
  request: string;
  is_done: boolean;
  message: string;
  requested_by: string;
}

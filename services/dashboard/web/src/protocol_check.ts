// Asks the gateway's checker about a protocol's text.

import { post } from "./access";
import type { ProtocolCheck } from "./protocol_words";

export const checkProtocol = async (text: string, seed: number): Promise<ProtocolCheck> =>
  (await (await post(`/api/protocols/check?seed=${seed}`, text)).json()) as ProtocolCheck;

/// A newer question makes an older answer void.
export class LatestCheck {
  #number = 0;

  async of(text: string, seed: number): Promise<ProtocolCheck | undefined> {
    const number = ++this.#number;
    const found = await checkProtocol(text, seed);
    return number === this.#number ? found : undefined;
  }

  forget(): void {
    ++this.#number;
  }
}

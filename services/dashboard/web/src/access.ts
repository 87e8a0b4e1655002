// The token of a gateway that requires one, entered once and kept for this tab. It may also come in the address after
// #token=, which no server sees.

const KEY = "tonus-token";

const fromAddress = new URLSearchParams(location.hash.slice(1)).get("token");
if (fromAddress) {
  sessionStorage.setItem(KEY, fromAddress);
  history.replaceState(null, "", location.pathname + location.search);
}

export const token = (): string => sessionStorage.getItem(KEY) ?? "";
export const keepToken = (secret: string): void => sessionStorage.setItem(KEY, secret);
export const forgetToken = (): void => sessionStorage.removeItem(KEY);

/// GET with the token; an error carries the gateway's message.
export const get = (path: string): Promise<Response> => ask(path, {});

/// POST of a text, likewise.
export const post = (path: string, body: string): Promise<Response> => ask(path, { method: "POST", body });

async function ask(path: string, request: RequestInit): Promise<Response> {
  const secret = token();
  const response = await fetch(path, { ...request, headers: secret ? { Authorization: `Bearer ${secret}` } : {} });
  if (response.ok) return response;
  let why = `${response.status} ${response.statusText}`;
  try {
    why = ((await response.json()) as { error: string }).error;
  } catch {
    // the response is not the gateway's JSON
  }
  throw new Error(why);
}

export const getJson = async <T>(path: string): Promise<T> => (await (await get(path)).json()) as T;

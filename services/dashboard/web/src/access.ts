// The token of a gateway that wants one: given once, kept for this tab. It may come in the address behind
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

/// GET with the token; an error holds the gateway's own words.
export async function get(path: string): Promise<Response> {
  const secret = token();
  const response = await fetch(path, { headers: secret ? { Authorization: `Bearer ${secret}` } : {} });
  if (response.ok) return response;
  let why = `${response.status} ${response.statusText}`;
  try {
    why = ((await response.json()) as { error: string }).error;
  } catch {
    // not the gateway's words
  }
  throw new Error(why);
}

export const getJson = async <T>(path: string): Promise<T> => (await (await get(path)).json()) as T;

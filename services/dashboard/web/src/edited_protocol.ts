// The protocol that was edited in this tab, for the form that starts a session.

const KEY = "tonus-edited-protocol";

export interface EditedProtocol {
  name: string;
  text: string;
}

export const keepEditedProtocol = (protocol: EditedProtocol): void => sessionStorage.setItem(KEY, JSON.stringify(protocol));

export function editedProtocol(): EditedProtocol | undefined {
  const kept = sessionStorage.getItem(KEY);
  return kept === null ? undefined : (JSON.parse(kept) as EditedProtocol);
}

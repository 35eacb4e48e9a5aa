import { ask } from './dialog.ts';

/** The key of the server that the user gave, kept as long as the tab. */
const PLACE = 'terrane-key';

export const hasKey = (): boolean => sessionStorage.getItem(PLACE) !== null;

/** The header that carries the key, if there is one. */
export function authorization(): Record<string, string> {
  const key = sessionStorage.getItem(PLACE);
  return key === null ? {} : { Authorization: `Bearer ${key}` };
}

let asking: Promise<boolean> | undefined;

async function askOnce(): Promise<boolean> {
  const error = hasKey() ? { error: 'The server knows no such key.' } : {};
  const reply = await ask({
    title: 'A key is needed',
    text: 'Who runs this server makes keys. This one is kept until the tab is closed.',
    lines: [{ label: 'Key', value: '', secret: true, ...error }],
    answers: [
      { id: 'cancel', label: 'Cancel' },
      { id: 'use', label: 'Use it', primary: true },
    ],
  });
  const [key] = reply?.texts ?? [];
  if (reply?.answer !== 'use' || !key) return false;
  sessionStorage.setItem(PLACE, key);
  return true;
}

/** Asks for a key, once for all who need one now; resolves to whether there is a new one. */
export function askKey(): Promise<boolean> {
  asking ??= askOnce().finally(() => (asking = undefined));
  return asking;
}

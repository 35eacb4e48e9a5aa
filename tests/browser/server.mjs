import { spawn } from 'node:child_process';
import { mkdtemp, rm } from 'node:fs/promises';
import { tmpdir } from 'node:os';
import { join } from 'node:path';
import { fileURLToPath } from 'node:url';

const BINARY = process.env.TERRANE_BIN ?? fileURLToPath(new URL('../../target/release/terrane', import.meta.url));

/** Starts the real server on a free port with an empty data folder. */
export async function startServer() {
  const data = await mkdtemp(join(tmpdir(), 'terrane-browser-'));
  const child = spawn(BINARY, ['serve', '--listen', '127.0.0.1:0', '--data', data], {
    stdio: ['ignore', 'inherit', 'pipe'],
    env: { ...process.env, NO_COLOR: '1' },
  });
  let log = '';
  const url = await new Promise((resolve, reject) => {
    child.stderr.setEncoding('utf8').on('data', (text) => {
      log += text;
      const found = /listening on (http:\/\/127\.0\.0\.1:\d+)/.exec(log);
      if (found) resolve(found[1]);
    });
    child.once('error', reject);
    child.once('exit', (code) => reject(new Error(`${BINARY} ended with ${code} before it listened:\n${log}`)));
  });
  const get = async (path) => {
    const response = await fetch(`${url}/${path}`);
    if (!response.ok) throw new Error(`${response.status} ${path}`);
    return response.json();
  };
  return {
    url,
    get,
    /** Everything the server has written to stderr, without colours. */
    log: () => log.replace(/\x1b\[[0-9;]*m/g, ''),
    revision: async (world) => (await get('catalog')).worlds.find(({ name }) => name === world)?.revision,
    async stop() {
      const ended = new Promise((resolve) => child.once('exit', resolve));
      if (child.exitCode === null && child.signalCode === null) {
        child.kill('SIGTERM');
        await ended;
      }
      await rm(data, { recursive: true, force: true });
      return child.exitCode;
    },
  };
}

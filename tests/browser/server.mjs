import { execFile, spawn } from 'node:child_process';
import { mkdtemp, rm } from 'node:fs/promises';
import { tmpdir } from 'node:os';
import { join } from 'node:path';
import { fileURLToPath } from 'node:url';
import { promisify } from 'node:util';

const BINARY = process.env.TERRANE_BIN ?? fileURLToPath(new URL('../../target/release/terrane', import.meta.url));

const run = promisify(execFile);

/** Starts the real server on a free port with an empty data folder, closed to those without the key if one is wished for. */
export async function startServer({ keyed = false } = {}) {
  const data = await mkdtemp(join(tmpdir(), 'terrane-browser-'));
  const key = keyed ? (await run(BINARY, ['key', 'new', 'a browser', '--data', data])).stdout.trim() : '';
  const child = spawn(BINARY, ['serve', '--listen', '127.0.0.1:0', '--data', data], {
    stdio: ['ignore', 'inherit', 'pipe'],
    env: { ...process.env, NO_COLOR: '1', ...(keyed ? { TERRANE_SERVER__READS: 'keys' } : {}) },
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
    key,
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

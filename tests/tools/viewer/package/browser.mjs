// SPDX-License-Identifier: GPL-3.0-or-later
// A server for folders, and headless Chromium with its software WebGL 2.
import {createReadStream, statSync} from 'node:fs';
import {createServer} from 'node:http';
import {extname, join, normalize} from 'node:path';

const TYPES = {
  '.html': 'text/html; charset=utf-8', '.js': 'text/javascript', '.json': 'application/json', '.css': 'text/css',
  '.jpg': 'image/jpeg', '.png': 'image/png', '.glb': 'model/gltf-binary',
};
const ARGUMENTS = [
  '--no-sandbox', '--use-angle=swiftshader', '--enable-unsafe-swiftshader', '--disable-gpu', '--disable-quic',
  '--no-first-run', '--disable-background-networking', '--disable-component-update', '--disable-sync',
  '--disable-dev-shm-usage',
];

// Serves `folders`, of which each has the addresses that begin with its name: {'/': FOLDER, '/model/': FOLDER}.
// `headers` come with every answer.
export async function served(folders, headers = {}) {
  const prefixes = Object.keys(folders).sort((a, b) => b.length - a.length);
  const server = createServer((request, response) => {
    const path = decodeURIComponent(new URL(request.url, 'http://x').pathname);
    const prefix = prefixes.find((name) => path.startsWith(name));
    const file = prefix && join(folders[prefix], normalize('/' + path.slice(prefix.length)));
    const found = file && statSync(file, {throwIfNoEntry: false});
    if (path === '/favicon.ico') return response.writeHead(204).end();
    if (!found?.isFile()) return response.writeHead(404, headers).end();
    const range = /^bytes=(\d+)-(\d+)$/.exec(request.headers.range ?? '');
    const [start, end] = range ? [Number(range[1]), Math.min(Number(range[2]), found.size - 1)] : [0, found.size - 1];
    response.writeHead(range ? 206 : 200, {
      ...headers, 'Content-Type': TYPES[extname(file)] ?? 'application/octet-stream', 'Content-Length': end + 1 - start,
    });
    if (request.method === 'HEAD') return response.end();
    return createReadStream(file, {start, end}).pipe(response);
  });
  await new Promise((resolve) => server.listen(0, '127.0.0.1', resolve));
  return {address: `http://127.0.0.1:${server.address().port}`, close: () => server.close()};
}

// Starts a browser from `puppeteer`, the module puppeteer-core.
export const started = (puppeteer, executablePath) =>
  puppeteer.launch({executablePath, args: ARGUMENTS, headless: true, dumpio: Boolean(process.env.DUMP), protocolTimeout: 120000});

// Opens a page in which each problem is noted in `problems`, and each WebGL context counts in `objects` what is made and
// not deleted.
export async function opened(browser, address, problems) {
  const page = await browser.newPage();
  await page.setViewport({width: 520, height: 390});
  page.on('pageerror', (error) => problems.push(String(error.stack ?? error)));
  page.on('console', (message) => {
    const text = `${message.text()} ${message.location().url ?? ''}`;
    if (['error', 'warn'].includes(message.type())) problems.push(text);
  });
  await page.evaluateOnNewDocument(() => {
    const {prototype} = WebGL2RenderingContext;
    for (const kind of ['Texture', 'Buffer', 'Framebuffer', 'Renderbuffer', 'VertexArray', 'Program']) {
      const [create, remove] = [prototype[`create${kind}`], prototype[`delete${kind}`]];
      prototype[`create${kind}`] = function() {
        this.objects = (this.objects ?? 0) + 1;
        return create.call(this);
      };
      prototype[`delete${kind}`] = function(object) {
        if (object) --this.objects;
        return remove.call(this, object);
      };
    }
  });
  await page.goto(address);
  return page;
}

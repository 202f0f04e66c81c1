// SPDX-License-Identifier: GPL-3.0-or-later
// usage: node pack.mjs WRITE_PAGE_SHADERS FOLDER
//
// Makes FOLDER/lumatlas-VERSION.tgz of this folder, the modules of ../page and the shaders that the built program
// WRITE_PAGE_SHADERS writes. VERSION is the project's, which the program says. FOLDER/lumatlas is what is packed.
import {execFileSync} from 'node:child_process';
import {cpSync, mkdirSync, readFileSync, readdirSync, rmSync, writeFileSync} from 'node:fs';
import {dirname, join} from 'node:path';
import {fileURLToPath} from 'node:url';

// Modules and folders that only the page of a site has.
const NOT_IN_PACKAGE = ['page.js', 'interface.js', 'elements.js', 'panels.js', 'saving.js', 'walking.js', 'quiet_controls.js',
  'fill.js', 'comparing.js',
  'measuring.js', 'surface_taps.js', 'annotations.js', 'owner_page.js', 'crop_controls.js', 'editor.js', 'path', 'headset_button.js'];
const FILES = ['README.md', 'index.d.ts', 'three.d.ts'];

const [program, folder] = process.argv.slice(2);
if (!program || !folder) {
  console.error('usage: node pack.mjs WRITE_PAGE_SHADERS FOLDER');
  process.exit(2);
}
const here = dirname(fileURLToPath(import.meta.url));
const packed = join(folder, 'lumatlas');

// A module of this folder finds those of ../page in ./page of the package. Types are for the check of the sources.
const asPacked = (text) => text.replaceAll("'../page/", "'./page/").replace(/\n *\/\*\*(?:[^*]|\*(?!\/))*\*\//g, '');

function copyScripts(from, to) {
  mkdirSync(to, {recursive: true});
  for (const entry of readdirSync(from, {withFileTypes: true})) {
    if (NOT_IN_PACKAGE.includes(entry.name)) continue;
    const [source, target] = [join(from, entry.name), join(to, entry.name)];
    if (entry.isDirectory() && entry.name !== 'examples') copyScripts(source, target);
    if (!entry.name.endsWith('.js')) continue;
    writeFileSync(target, asPacked(readFileSync(source, 'utf8')));
  }
}

rmSync(packed, {recursive: true, force: true});
copyScripts(join(here, '../page'), join(packed, 'page'));
copyScripts(here, packed);
const shaders = JSON.parse(execFileSync(program, {encoding: 'utf8', maxBuffer: 1 << 28}));
const {lumatlas: version} = shaders;
writeFileSync(join(packed, 'shaders.js'), `// SPDX-License-Identifier: GPL-3.0-or-later
// The shaders of lumatlas, and how it blends.
export const shaders = ${JSON.stringify(shaders)};
`);
for (const name of FILES) cpSync(join(here, name), join(packed, name));
cpSync(join(here, '../../../LICENSE'), join(packed, 'LICENSE'));
const description = JSON.parse(readFileSync(join(here, 'package.json'), 'utf8'));
writeFileSync(join(packed, 'package.json'), JSON.stringify({...description, version}, null, 2) + '\n');
const packing = execFileSync('npm', ['pack', '--json', '--pack-destination', '..'], {cwd: packed, encoding: 'utf8'});
const [{filename, size, unpackedSize}] = JSON.parse(packing);
console.log(`${join(folder, filename)}: ${size} bytes, unpacked ${unpackedSize}`);

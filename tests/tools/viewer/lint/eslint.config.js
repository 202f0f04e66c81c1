// SPDX-License-Identifier: GPL-3.0-or-later
// The rules of the page's scripts. Names without a definition are left to the type checker, which knows the browser's.
import js from '@eslint/js';

const FETCHES = ['fetch', 'XMLHttpRequest', 'WebSocket', 'EventSource'];
const GL_OBJECTS = 'Texture|Buffer|Framebuffer|Renderbuffer|VertexArray|Program|Shader|Sampler|Query|TransformFeedback';

export default [
  js.configs.recommended,
  {
    linterOptions: {reportUnusedDisableDirectives: 'error', noInlineConfig: true},
    rules: {
      'no-undef': 'off',
      'eqeqeq': 'error',
      'no-var': 'error',
      'prefer-const': 'error',
      'no-shadow': ['error', {builtinGlobals: false}],
      'no-implicit-globals': 'error',
      'no-eval': 'error',
      'no-implied-eval': 'error',
      'no-new-func': 'error',
      'no-alert': 'error',
      'no-throw-literal': 'error',
      'no-unused-vars': ['error', {args: 'after-used'}],
      'no-restricted-properties': ['error', {property: 'innerHTML'}, {property: 'outerHTML'}],
      // Types are checked everywhere, and are types.
      'no-warning-comments': [
        'error', {terms: ['@ts-ignore', '@ts-nocheck', '@ts-expect-error', '{any}', '{*}', '<any'], location: 'anywhere'},
      ],
      'max-len': ['error', {code: 120, ignoreUrls: true}],
    },
  },
  {
    files: ['**/page/**/*.js'],
    ignores: ['**/fetching.js'],
    rules: {
      'no-restricted-globals': ['error', ...FETCHES.map((name) => ({name, message: 'fetching.js makes all requests.'}))],
    },
  },
  {
    files: ['**/page/**/*.js'],
    ignores: ['**/gl_objects.js'],
    rules: {
      'no-restricted-syntax': ['error', {
        selector: `CallExpression > MemberExpression > Identifier.property[name=/^((create|delete)(${GL_OBJECTS})|fenceSync|deleteSync)$/]`,
        message: 'gl_objects.js makes and deletes what is on the GPU.',
      }],
    },
  },
];

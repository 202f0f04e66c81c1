// SPDX-License-Identifier: GPL-3.0-or-later
// The rules of the page's scripts. Names without a definition are left to the type checker, which knows the browser's.
import js from '@eslint/js';

const FETCHES = ['fetch', 'XMLHttpRequest', 'WebSocket', 'EventSource'];
const GL_OBJECTS = 'Texture|Buffer|Framebuffer|Renderbuffer|VertexArray|Program|Shader|Sampler|Query|TransformFeedback';

const OF_GL = {
  selector: `CallExpression > MemberExpression > Identifier.property[name=/^((create|delete)(${GL_OBJECTS})|fenceSync|deleteSync)$/]`,
  message: 'gl_objects.js makes and deletes what is on the GPU.',
};

// What visitors read stands in the tables of texts: words with a space between them, and what becomes an element's text.
const WORDS = '/[A-Za-z]{2,}[,.:]? [A-Za-z]{2,}/';
const SHOWN = '/^(textContent|innerText|title|alt|placeholder|ariaLabel)$/';
const INSIDE_TABLES = 'texts/en.js and the other tables hold what visitors read.';
const OTHERWISE = 'NewExpression[callee.name=/Error$/] *, ' +
    'CallExpression[callee.name="matchMedia"] *, ' +
    'CallExpression[callee.property.name=/^(matches|querySelector|querySelectorAll)$/] *';
const TEXTS = [
  `Literal[value=${WORDS}]:not(${OTHERWISE})`,
  `TemplateElement[value.raw=${WORDS}]:not(${OTHERWISE})`,
  `AssignmentExpression[left.property.name=${SHOWN}] > Literal.right[value=/[A-Za-z]{2}/]`,
  `AssignmentExpression[left.property.name=${SHOWN}] > TemplateLiteral.right > TemplateElement[value.raw=/[A-Za-z]{2}/]`,
  'CallExpression[callee.property.name="setAttribute"][arguments.0.value=/^(aria-label|title|aria-valuetext)$/]' +
      ' > :matches(Literal, TemplateLiteral)[value!=/^[a-z-]+$/]:nth-child(2)',
  'CallExpression[callee.name="actionButton"] > Literal[value=/[A-Za-z]/]',
].map((selector) => ({selector, message: INSIDE_TABLES}));

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
    files: ['**/page/texts/??.js'],
    rules: {'max-len': 'off'},  // a text is one line
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
    ignores: ['**/gl_objects.js', '**/page/texts/??.js'],
    rules: {'no-restricted-syntax': ['error', OF_GL, ...TEXTS]},
  },
  {
    // These name passes and programs, and say what is wrong with a file's bytes.
    files: ['**/page/drawing/*.js', '**/page/reading/meshopt.js'],
    ignores: ['**/gl_objects.js'],
    rules: {'no-restricted-syntax': ['error', OF_GL]},
  },
];

// SPDX-License-Identifier: GPL-3.0-or-later
// Types of shaders.js, which pack.mjs writes.
import type {Shaders} from '../page/types.d.ts';

export const shaders: Shaders;

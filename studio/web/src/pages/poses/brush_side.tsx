// The brush's tools beside the photograph.
import type { ComponentChildren } from 'preact'

import { percent } from '../../words'
import type { Tool } from './brush_surface'
import type { MaskLook } from './mask_canvas'
import { Flags } from './flags'
import { signedPercent } from './quality'
import type { Judged } from './quality'

export const kSmallest = 2
export const kLargest = 600

/** The slider's places go up by a share, not by a number: small sizes need the finer steps. */
const kPlaces = 200
const sizeAt = (place: number) =>
  Math.round(kSmallest * (kLargest / kSmallest) ** (place / kPlaces))
const placeOf = (size: number) =>
  Math.round((kPlaces * Math.log(size / kSmallest)) / Math.log(kLargest / kSmallest))

/** The next size up or down; at least by one pixel. */
export function stepSize(size: number, up: boolean): number {
  const next = up ? Math.max(size + 1, size * 1.2) : Math.min(size - 1, size / 1.2)
  return Math.round(Math.min(kLargest, Math.max(kSmallest, next)))
}

const kShapes: [Tool['shape'], string, string, string][] = [
  ['brush', 'Brush', 'B', 'Paints along the stroke'],
  ['lasso', 'Lasso', 'L', 'All that a line goes round'],
  ['fill', 'Fill', 'F', 'All that hangs together with the place: a hole, a speck'],
]

const kLooks: [MaskLook, string][] = [
  ['tint', 'Tint'],
  ['outline', 'Outline'],
  ['figure', 'Only figure'],
]

const kKeys: [string, string][] = [
  ['A  R', 'add, remove (Alt: the other)'],
  ['B  L  F', 'brush, lasso, fill'],
  ['I', 'invert'],
  ['[  ]', 'smaller, larger'],
  ['T', 'tint, outline, figure'],
  ['Space', 'hold to move'],
  ['Wheel', 'zoom; 0 fits, 1 is 100 %'],
  ['PgUp PgDn', 'other photograph'],
  ['← → ↑ ↓ ⏎', 'move, dab or set a corner'],
]

function Group({ name, children }: { name: string; children: ComponentChildren }) {
  return (
    <section class="stack group" aria-label={name}>
      <h2 class="label">{name}</h2>
      {children}
    </section>
  )
}

export function BrushTools({ tool, change }: { tool: Tool; change: (tool: Tool) => void }) {
  const mode = (value: Tool['mode'], words: string, key: string) => (
    <button
      aria-pressed={tool.mode === value}
      aria-keyshortcuts={key}
      onClick={() => change({ ...tool, mode: value })}
    >
      {words} <kbd>{key}</kbd>
    </button>
  )
  return (
    <>
      <Group name="Tool">
        <div class="choice wide" role="group" aria-label="With what">
          {kShapes.map(([shape, words, key, about]) => (
            <button
              key={shape}
              title={about}
              aria-pressed={tool.shape === shape}
              aria-keyshortcuts={key}
              onClick={() => change({ ...tool, shape })}
            >
              {words} <kbd>{key}</kbd>
            </button>
          ))}
        </div>
        <div class="choice wide" role="group" aria-label="What it does">
          {mode('add', 'Add', 'A')}
          {mode('remove', 'Remove', 'R')}
        </div>
        <div class="slider">
          <label for="brush-size">Size</label>
          <input
            id="brush-size"
            type="range"
            min={0}
            max={kPlaces}
            value={placeOf(tool.size)}
            disabled={tool.shape !== 'brush'}
            aria-valuetext={`${tool.size} pixels`}
            onInput={(event) =>
              change({ ...tool, size: sizeAt(Number(event.currentTarget.value)) })
            }
          />
          <span class="number small">{tool.size} px</span>
        </div>
      </Group>
      <Group name="Show">
        <div class="choice wide" role="group" aria-label="How the mask is shown">
          {kLooks.map(([look, words]) => (
            <button
              key={look}
              aria-pressed={tool.look === look}
              onClick={() => change({ ...tool, look })}
            >
              {words}
            </button>
          ))}
        </div>
      </Group>
    </>
  )
}

/** What changes the mask as a whole; undone as a stroke is. */
export function WholeMask(props: {
  invert: () => void
  /** the photographs before and after this one, '' where there is none */
  before: string
  after: string
  take: (name: string) => void
}) {
  const { before, after, take } = props
  return (
    <Group name="Whole mask">
      <div class="choice wide">
        <button
          aria-keyshortcuts="I"
          title="The figure is what was not (I)"
          onClick={props.invert}
        >
          Invert
        </button>
        <button
          disabled={!before}
          title={`Takes the mask of ${before || 'the photograph before'}`}
          onClick={() => take(before)}
        >
          As before
        </button>
        <button
          disabled={!after}
          title={`Takes the mask of ${after || 'the photograph after'}`}
          onClick={() => take(after)}
        >
          As after
        </button>
      </div>
    </Group>
  )
}

export function BrushHistory(props: {
  canUndo: boolean
  canRedo: boolean
  undo: () => void
  redo: () => void
}) {
  return (
    <div class="choice wide" role="group" aria-label="Strokes">
      <button disabled={!props.canUndo} aria-keyshortcuts="Control+Z" onClick={props.undo}>
        ↶ Undo
      </button>
      <button disabled={!props.canRedo} aria-keyshortcuts="Control+Shift+Z" onClick={props.redo}>
        ↷ Redo
      </button>
    </div>
  )
}

export function Measures({ judged }: { judged: Judged }) {
  const { photograph, sharpness, exposure } = judged
  if (!photograph.captured) return <p class="small soft">Not captured yet: press Run.</p>
  return (
    <dl class="facts small">
      <dt>Sharpness</dt>
      <dd>{percent(sharpness)}</dd>
      <dt>Exposure</dt>
      <dd>{signedPercent(exposure)}</dd>
      <dt>Figure</dt>
      <dd>{percent(photograph.mask_fraction, 1)}</dd>
      {judged.flags.length > 0 && (
        <>
          <dt>Look at</dt>
          <dd>
            <Flags judged={judged} words />
          </dd>
        </>
      )}
    </dl>
  )
}

export function BrushKeys() {
  return (
    <details class="keys small" open={innerHeight >= 900}>
      <summary>Keys</summary>
      <dl>
        {kKeys.map(([key, words]) => (
          <>
            <dt>
              <kbd>{key}</kbd>
            </dt>
            <dd>{words}</dd>
          </>
        ))}
      </dl>
    </details>
  )
}

// Beside the mesh that is mended: the brush, before and after, the strokes, what runs again.
import type { MendStroke } from '../../api'
import { useStudio } from '../../state'
import type { Viewer } from '../../view/viewer'
import { count, duration, percent, sentence } from '../../words'
import { UndoButtons } from '../landmarks/pair_list'
import { kLargestMend, kMendTools, kSmallestMend, strokeName } from './mend_model'
import type { MendBrush } from './mend_model'
import type { MendDesk } from './use_mending'

export type MendLook = 'before' | 'after' | 'moved'

const kLooks: [MendLook, string, string][] = [
  ['before', 'Before', 'As it was made (B)'],
  ['after', 'Mended', 'With all strokes (B)'],
  ['moved', 'Moved', 'In colours: how far each place was moved'],
]
const kShort = 1 // [s]: not worth a word

interface SideProps {
  pose: string
  desk: MendDesk
  brush: MendBrush
  look: MendLook
  viewer: Viewer | null
  change: (brush: MendBrush) => void
  show: (look: MendLook) => void
}

export function MendSide(props: SideProps) {
  const { desk, look, show } = props
  return (
    <aside class="figure-side" aria-label="Mend">
      <BrushPart {...props} />
      <section class="stack" aria-label="Compare">
        <div class="choice wide" role="group" aria-label="What to show">
          {kLooks.map(([one, words, about]) => (
            <button key={one} title={about} aria-pressed={look === one} onClick={() => show(one)}>
              {words}
            </button>
          ))}
        </div>
      </section>
      <StrokeList {...props} />
      <After desk={desk} pose={props.pose} />
    </aside>
  )
}

function BrushPart({ brush, change }: SideProps) {
  const { tool } = brush
  const strength = brush.strength[tool]
  const set = (value: number) =>
    change({ ...brush, strength: { ...brush.strength, [tool]: value } })
  const sign = strength < 0 ? -1 : 1
  return (
    <section class="stack" aria-label="Brush">
      <h2>Mend the mesh</h2>
      <div class="choice wide" role="group" aria-label="What the brush does">
        {kMendTools.map(([one, words, key, about]) => (
          <button
            key={one}
            title={`${about} (${key})`}
            aria-pressed={tool === one}
            aria-keyshortcuts={key}
            onClick={() => change({ ...brush, tool: one })}
          >
            {words}
          </button>
        ))}
      </div>
      <p class="small soft">{kMendTools.find(([one]) => one === tool)![3]}.</p>
      {tool === 'pull' && (
        <div class="choice wide" role="group" aria-label="Direction">
          {([1, -1] as const).map((way) => (
            <button
              key={way}
              aria-pressed={sign === way}
              onClick={() => set(way * Math.abs(strength))}
            >
              {way > 0 ? 'Out' : 'In'}
            </button>
          ))}
        </div>
      )}
      <label class="mend-slider small">
        Radius
        <input
          type="range"
          min={kSmallestMend}
          max={kLargestMend}
          step={0.005}
          value={brush.radius}
          aria-valuetext={`${percent(brush.radius, 1)} of the figure`}
          aria-keyshortcuts="[ ]"
          onInput={(event) => change({ ...brush, radius: Number(event.currentTarget.value) })}
        />
        <span class="number">{percent(brush.radius, 1)}</span>
      </label>
      <label class="mend-slider small">
        Strength
        <input
          type="range"
          min={0.05}
          max={1}
          step={0.05}
          value={Math.abs(strength)}
          aria-valuetext={percent(Math.abs(strength))}
          onInput={(event) => set(sign * Number(event.currentTarget.value))}
        />
        <span class="number">{percent(Math.abs(strength))}</span>
      </label>
    </section>
  )
}

function StrokeList({ desk, viewer }: SideProps) {
  const { strokes, mending } = desk
  const list = strokes.clicks
  const lost = list.filter((stroke) => stroke.fault !== '')
  const keep = (wanted: (stroke: MendStroke, index: number) => boolean) =>
    strokes.change('taken out', list.filter(wanted))
  const look = (stroke: MendStroke) => {
    const place = stroke.places[0]
    if (!viewer || !place) return
    const at = viewer.placeOf(place.face, place.barycentric)
    viewer.focusOn(at, viewer.turn().direction, Math.min(viewer.turn().distance, 0.7))
  }
  return (
    <section class="stack" aria-labelledby="mend-list-title">
      <div class="row spread">
        <h3 id="mend-list-title">Strokes · {list.length}</h3>
        <UndoButtons
          undo={() => void strokes.undo()}
          redo={() => void strokes.redo()}
          canUndo={strokes.canUndo}
          canRedo={strokes.canRedo}
        />
      </div>
      {mending?.problem && <p class="bad small">{sentence(mending.problem)}</p>}
      {desk.fault && <p class="bad small">{sentence(desk.fault)}</p>}
      {lost.length > 0 && (
        <div class="stack">
          <p class="bad small">
            {count(lost.length, 'stroke')} {lost.length === 1 ? 'does' : 'do'} not lie on the mesh any more,
            as that was made anew. The next run stops there.
          </p>
          <button onClick={() => keep((stroke) => stroke.fault === '')}>Take them out</button>
        </div>
      )}
      {list.length === 0 && <p class="small soft">None yet.</p>}
      <ul class="figure-list mend-list">
        {list.map((stroke, i) => (
          <li key={i}>
            <button class="quiet where" title={stroke.fault || 'Look at it'} onClick={() => look(stroke)}>
              <span class="number soft">{i + 1}</span>
              <span class="name">{strokeName(stroke)}</span>
              <span class={stroke.fault ? 'small bad' : 'small soft'}>
                {stroke.fault ? 'lost' : percent(Math.abs(stroke.strength))}
              </span>
            </button>
            <button
              class="quiet"
              aria-label={`Take out stroke ${i + 1}, ${strokeName(stroke)}`}
              onClick={() => keep((_, other) => other !== i)}
            >
              ×
            </button>
          </li>
        ))}
      </ul>
    </section>
  )
}

/** Whether all is saved, and what the next run makes again. */
function After({ desk, pose }: { desk: MendDesk; pose: string }) {
  const { steps } = useStudio()
  const { strokes, mending } = desk
  const again = mending!.again
  const step = steps.steps.find((one) => one.step === 'mend' && one.pose === pose)
  const time = again.seconds > kShort ? `; they took ${duration(again.seconds)} last time` : ''
  const made = step?.state === 'done' || (strokes.clicks.length === 0 && !step)
  return (
    <p class="small soft" role="status">
      {strokes.failed
        ? `Not saved: ${strokes.failed}`
        : made
          ? 'A change makes again what comes after the mesh: '
          : 'Saved. The next run mends the mesh and makes again what comes after it: '}
      {!strokes.failed && `${count(again.follow.length, 'step')}${time}.`}
    </p>
  )
}

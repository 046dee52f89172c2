// Sensors with what is wrong with them, and how well each chain meets its anchors.
import { Act } from '../shoot/controls'
import type { ArmaturePose, ArmatureView } from './armature_api'
import type { Sitting } from './sitting'

interface Row {
  index: number
  name: string
  unit: string
  /** '' : nothing is wrong */
  state: string
  words: string
  fault: boolean
}

export function rowsOf(
  view: ArmatureView,
  sitting: Sitting,
  held: number[],
  wraps: number[],
): Row[] {
  const rows = view.sensors.map(({ name, unit }, index) => {
    const trouble = sitting.sensors[name]
    const wrapped = wraps[index] > 0 ? `wrapped × ${wraps[index]}` : ''
    const state = trouble?.kind ?? (held.includes(index) ? 'jumped' : wrapped)
    const fault = trouble !== undefined || held.includes(index)
    return { index, name, unit, state, words: trouble?.words ?? '', fault }
  })
  // What is wrong comes first; the rest stays in the armature's order.
  return [...rows.filter((row) => row.fault), ...rows.filter((row) => !row.fault)]
}

const share = (part: number) => (100 * part).toFixed(part < 1e-9 ? 0 : 2)

export function Readings(props: {
  view: ArmatureView
  sitting: Sitting
  reading: ArmaturePose | null
  zero: (joint: string) => void
}) {
  const { view, sitting, reading } = props
  const rows = rowsOf(view, sitting, reading?.held ?? [], reading?.wraps ?? [])
  return (
    <aside class="shoot-landed armature-readings" aria-label="Readings" tabIndex={0}>
      <section>
        <h3>Chains, in % of their length</h3>
        <table>
          <thead>
            <tr>
              <th scope="col">Chain</th>
              <th scope="col">near</th>
              <th scope="col">far</th>
              <th scope="col">off</th>
            </tr>
          </thead>
          <tbody>
            {view.chains.map(({ name, exact }, c) => (
              <tr key={name}>
                <td>
                  {name}
                  {exact && '*'}
                </td>
                {[0, 1, 2].map((k) => {
                  const part = reading?.chains[c]?.[k] ?? 0
                  return (
                    <td key={k} class={`number ${k < 2 && !exact && part > 1e-3 ? 'warn' : ''}`}>
                      {share(part)}
                    </td>
                  )
                })}
              </tr>
            ))}
          </tbody>
        </table>
        <p class="small soft">
          Gaps at both anchors; how far joints are off the puppet’s.
          {view.chains.some((one) => one.exact) &&
            ' * keeps the puppet’s angles, and so misses the far anchor where lengths differ.'}
        </p>
      </section>
      <section>
        <h3>Board</h3>
        <p class={`small ${reading && !reading.fresh ? 'bad' : 'soft'}`}>
          {reading && !reading.fresh ? 'Does not answer. ' : 'Answers. '}
          {reading?.repeats ?? 0} asked again, {reading?.damaged ?? 0} damaged
        </p>
      </section>
      <section>
        <h3>{view.sensors.length} sensors</h3>
        <ul class="armature-sensors">
          {rows.map((row) => (
            <li key={row.name} class={row.fault ? 'fault' : ''} title={row.words}>
              <span>{row.name}</span>
              {row.state && <span class={`tag ${row.fault ? 'bad' : 'soft'}`}>{row.state}</span>}
              <span class="number">
                {(reading?.values[row.index] ?? 0).toFixed(1)} {row.unit}
              </span>
              {row.fault && (
                <div class="mend">
                  {row.words && <p class="small">{row.words}</p>}
                  <Act act={() => props.zero(row.name)}>It stands at zero</Act>
                </div>
              )}
            </li>
          ))}
        </ul>
      </section>
    </aside>
  )
}

// The photographs as they land, newest first, with what was found.
import { useEffect, useRef } from 'preact/hooks'

import { api } from '../../api'
import { count, sentence } from '../../words'
import { degrees } from './ring_map'
import type { Finding, Landed, Session } from './session'

export function Findings({ findings }: { findings: Finding[] }) {
  return (
    <ul class="shoot-findings">
      {findings.map((one) => (
        <li key={one.code}>
          <b>{sentence(one.words)}</b> {sentence(one.do)}
        </li>
      ))}
    </ul>
  )
}

function Row(props: { one: Landed; chosen: boolean; choose: () => void }) {
  const { one } = props
  const row = useRef<HTMLLIElement>(null)
  useEffect(() => {
    if (props.chosen) row.current!.scrollIntoView({ block: 'nearest' })
  }, [props.chosen])
  return (
    <li ref={row} class={one.findings.length > 0 ? 'warned' : ''}>
      <button aria-pressed={props.chosen} onClick={props.choose}>
        <img src={api.landedUrl(one.path, one.version, 160)} alt="" loading="lazy" />
        <span>
          <b class="number">{degrees(one.angle_deg)}</b>
          <span class="soft small number">
            ring {one.ring}
            {one.flip > 0 ? ', lying' : ''}
          </span>
          {one.findings.length === 0 && <span class="good small">good</span>}
        </span>
      </button>
      {one.findings.length > 0 && <Findings findings={one.findings} />}
    </li>
  )
}

export function LandedList(props: {
  session: Session
  chosen: string
  choose: (name: string) => void
}) {
  const { session } = props
  const names = [...session.landed].reverse()
  const warned = names.filter((name) => session.photographs[name].findings.length > 0).length
  const rings = session.rings.filter((ring) => ring.findings.length > 0)
  return (
    <section class="shoot-landed" aria-label="Photographs">
      <header class="row spread">
        <h2>{count(names.length, 'photograph')}</h2>
        {warned > 0 && <span class="warn small number">{warned} to look at</span>}
      </header>
      {rings.map((ring) => (
        <div key={`${ring.flip} ${ring.ring}`} class="of-ring">
          <h3>
            Ring {ring.ring}
            {ring.flip > 0 ? ', lying' : ''}
          </h3>
          <Findings findings={ring.findings} />
        </div>
      ))}
      {names.length === 0 && <p class="soft small">They show here as they land.</p>}
      <ol>
        {names.map((name) => (
          <Row
            key={name}
            one={session.photographs[name]}
            chosen={name === props.chosen}
            choose={() => props.choose(name)}
          />
        ))}
      </ol>
    </section>
  )
}

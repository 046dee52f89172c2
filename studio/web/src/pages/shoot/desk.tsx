// A session at work: live picture, rings, what has landed, and the keys for all of it.
import { useState } from 'preact/hooks'

import { api } from '../../api'
import { Bar } from '../../bar'
import { useKeys } from '../../keys'
import { useStudio } from '../../state'
import { Act, doingWords, isAtWork, mainAct, NextPose, Say } from './controls'
import { AidButtons, useAids } from './aids_view'
import { Findings, LandedList } from './landed_list'
import { LandedView, LiveView, OnionSlider } from './live_view'
import { RingDiagram } from './ring_diagram'
import { kAids } from './live_aids'
import { aheadOf, nameOf, placeOf } from './ring_map'
import type { Session } from './session'

/** All names in the order of the rings, for the arrow keys. */
function inOrder(session: Session): string[] {
  const key = (name: string) => {
    const { flip, ring, angle_deg } = session.photographs[name] ?? placeOf(name)
    return 1e6 * flip + 1e3 * ring + angle_deg
  }
  return Object.keys(session.photographs).sort((a, b) => key(a) - key(b))
}

function useChosen(session: Session) {
  const [name, choose] = useState('')
  const chosen = session.photographs[name] ?? null
  const step = (by: number) => {
    const names = inOrder(session)
    if (names.length === 0) return
    const at = names.indexOf(name)
    choose(names[at < 0 ? names.length - 1 : (at + by + names.length) % names.length])
  }
  return { chosen, choose, step }
}

export function Desk({ session }: { session: Session }) {
  const { project, complain } = useStudio()
  const [onion, setOnion] = useState(0.4)
  const [naming, setNaming] = useState(false)
  const [live, setLive] = useState(true)
  const { chosen, choose, step } = useChosen(session)
  const aids = useAids()
  const tell = (command: string, fields: Record<string, unknown> = {}) =>
    void api.tellShoot({ command, ...fields }).catch(complain)
  const main = mainAct(session)
  const acts = {
    main: () => main && tell(main.command),
    again: () => {
      const photograph = chosen?.name ?? session.landed[session.landed.length - 1]
      if (photograph) tell('again', { photograph })
      choose('')
    },
    skip: () => {
      const next = aheadOf(session)
      // A pause names what was shot last; all others know better what is next than this page.
      if (next) tell('skip', session.next ? {} : { photograph: nameOf(next), id: nameOf(next) })
    },
    pause: () => tell(session.doing === 'paused' ? 'go-on' : 'pause'),
    next: () => setNaming(true),
    live: () => {
      tell('live', { on: !live })
      setLive(!live)
    },
  }
  useKeys({
    ' ': acts.main,
    Enter: acts.main,
    a: acts.again,
    s: acts.skip,
    p: acts.pause,
    n: acts.next,
    l: acts.live,
    ...Object.fromEntries(kAids.map(([aid, , key]) => [key, () => aids.toggle(aid)])),
    ArrowLeft: () => step(-1),
    ArrowRight: () => step(1),
    Escape: () => (naming ? setNaming(false) : choose('')),
  })
  const goOn = (pose: string, angles: number | null) => {
    setNaming(false)
    choose('')
    tell('next-pose', angles === null ? { pose } : { pose, angles })
  }
  return (
    <main class="page shoot-page">
      <h1 class="hidden">Shooting {session.pose}</h1>
      <aside class="side" aria-label="Session">
        <Progress session={session} />
        <RingDiagram session={session} chosen={chosen?.name ?? ''} choose={choose} />
        <Buttons
          session={session}
          acts={acts}
          live={live}
          tell={tell}
          again={chosen ? 'this one' : 'the last'}
        />
      </aside>
      <div class="work">
        <div class="shoot-screen">
          {chosen ? (
            <LandedView one={chosen} live={() => choose('')} />
          ) : (
            <LiveView session={session} onion={onion} aids={aids.on}>
              <OnionSlider session={session} share={onion} setShare={setOnion} />
              <AidButtons {...aids} />
            </LiveView>
          )}
        </div>
        <div class="shoot-foot">
          <div class="words">
            {chosen && chosen.findings.length > 0 && !session.ask && !session.fault ? (
              <Findings findings={chosen.findings} />
            ) : (
              <Say session={session} />
            )}
          </div>
          {naming ? (
            <NextPose session={session} template={project.template} go={goOn} close={() => setNaming(false)} />
          ) : (
            <MainButton session={session} act={acts.main} next={acts.next} />
          )}
        </div>
      </div>
      <LandedList session={session} chosen={chosen?.name ?? ''} choose={choose} />
    </main>
  )
}

function Progress({ session }: { session: Session }) {
  const share = session.total > 0 ? session.done / session.total : 0
  return (
    <section class="stack" style="gap:6px">
      <div class="row spread">
        <h2>{session.pose}</h2>
        <span class="number">
          {session.done} of {session.total}
        </span>
      </div>
      <Bar share={share} label={`${session.pose}: photographs`} />
      <p class="small soft" role="status">
        {doingWords(session)}
      </p>
      {session.bentFrom && (
        <p class="small soft">{session.bentFrom} will be bent into these photographs.</p>
      )}
    </section>
  )
}

/** A camera that does not answer holds the session up: the second press does not wait for it. */
function EndButton({ tell }: { tell: (command: string) => void }) {
  const { complain } = useStudio()
  const [asked, setAsked] = useState(false)
  if (asked)
    return (
      <Act act={() => void api.interruptShoot().catch(complain)}>Ends … Press again: at once</Act>
    )
  return (
    <Act
      act={() => {
        setAsked(true)
        tell('end')
      }}
    >
      End
    </Act>
  )
}

function MainButton(props: { session: Session; act: () => void; next: () => void }) {
  const { session } = props
  const main = mainAct(session)
  if (session.doing === 'idle')
    return (
      <Act main keys="N" act={props.next}>
        Next pose
      </Act>
    )
  return (
    <Act main keys="Space" disabled={!main} act={props.act}>
      {main?.words ?? 'Shoot'}
    </Act>
  )
}

function Buttons(props: {
  session: Session
  acts: Record<'again' | 'skip' | 'pause' | 'next' | 'live', () => void>
  live: boolean
  tell: (command: string) => void
  again: string
}) {
  const { session, acts } = props
  const paused = session.doing === 'paused'
  return (
    <div class="shoot-buttons">
      <Act keys="A" disabled={session.landed.length === 0} act={acts.again}>
        Again <span class="soft">{props.again}</span>
      </Act>
      <Act keys="S" disabled={!aheadOf(session)} act={acts.skip}>
        Skip
      </Act>
      <Act keys="P" disabled={!paused && !isAtWork(session)} act={acts.pause}>
        {paused ? 'Go on' : 'Pause'}
      </Act>
      <Act keys="L" act={acts.live}>
        {props.live ? 'Live off' : 'Live on'}
      </Act>
      <Act keys="N" act={acts.next}>
        Next pose
      </Act>
      <EndButton tell={props.tell} />
    </div>
  )
}

// Shooting: set up, then photograph pose after pose with live view. The session is `keypose shoot`.
import { useState } from 'preact/hooks'

import { api } from '../api'
import type { ShootStory } from '../api'
import { useStudio } from '../state'
import { sentence } from '../words'
import { Desk } from './shoot/desk'
import { Act } from './shoot/controls'
import { RingDiagram } from './shoot/ring_diagram'
import { kNoSession } from './shoot/session'
import type { Session } from './shoot/session'
import { ringsOf } from './shoot/setup'
import type { Draft } from './shoot/setup'
import { SetupFields, useSetup } from './shoot/setup_form'
import './shoot/shoot.css'
import { useSession } from './shoot/use_session'

export function ShootPage() {
  const { session, story, load } = useSession()
  if (!session || !story) return <main class="empty">Looks for a session …</main>
  if (session.running) return <Desk session={session} />
  return <Begin session={session} story={story} load={load} />
}

/** The plan of the form, as if nothing had been shot. */
function planned(draft: Draft, before: Session): Session {
  const rings_deg = ringsOf(draft.rings) ?? []
  const angles = Math.min(360, Math.max(0, Math.round(Number(draft.angles)) || 0))
  const plan = { rings_deg, angles, flips: draft.flips }
  const same =
    before.pose === draft.pose &&
    before.plan.angles === angles &&
    before.plan.rings_deg.join() === rings_deg.join()
  const shown = same ? before : { ...kNoSession, pose: draft.pose }
  return { ...shown, plan, doing: 'ended', next: '' }
}

function Begin(props: { session: Session; story: ShootStory; load: () => Promise<void> }) {
  const { session, story, load } = props
  const { project, complain } = useStudio()
  const form = useSetup(story, session.pose)
  const [busy, setBusy] = useState(false)
  const known = project.poses.find((one) => one.name === form.draft.pose)
  const goesOn = known !== undefined && known.photographs > 0
  const begin = async () => {
    const setup = form.ready()
    if (!setup) return
    setBusy(true)
    try {
      await api.startShoot(setup)
      await load()
    } catch (error) {
      complain(error)
    }
    setBusy(false)
  }
  return (
    <main class="page shoot-page begin">
      <h1 class="hidden">Shoot</h1>
      <aside class="side" aria-label="Set-up">
        <form
          class="stack"
          onSubmit={(event) => {
            event.preventDefault()
            void begin()
          }}
        >
          <SetupFields form={form} ports={story.ports} />
          <button class="main" disabled={busy}>
            {goesOn ? `Go on with ${form.draft.pose}` : 'Begin'}
          </button>
        </form>
      </aside>
      <div class="work">
        <div class="shoot-begin">
          <Ended session={session} />
          <RingDiagram session={planned(form.draft, session)} chosen="" choose={() => undefined} />
          <Advice draft={form.draft} />
        </div>
      </div>
    </main>
  )
}

/** How the last session ended, and what comes next. */
function Ended({ session }: { session: Session }) {
  if (session.failure)
    return (
      <div class="shoot-say fault" role="alert">
        <p>
          <b>The session could not go on.</b>
        </p>
        <p>{sentence(session.failure)}</p>
        <p class="small soft">
          What was shot is in the project. Begin again: it goes on where it was.
        </p>
      </div>
    )
  if (!session.ended) return null
  return (
    <div class="shoot-say" role="status">
      <p>
        <b>{sentence(session.ended)}</b>
      </p>
      <div class="row">
        <a class="button" href={`#/poses/${encodeURIComponent(session.pose)}/photographs`}>
          Look at them
        </a>
        <Act act={() => void (location.hash = '#/run')}>To the run</Act>
      </div>
    </div>
  )
}

function Advice({ draft }: { draft: Draft }) {
  const steps = [
    'Camera on a tripod, so near that the figure fills the picture. Do not move it ' +
      'between poses: all of them then have one scale.',
    'Exposure, white balance, focus and zoom on manual.',
    'The figure in the middle of the table, the table’s mark at 0°.',
    draft.table === 'none'
      ? 'Press Begin: the page says to which angle to turn, you press Space.'
      : 'Press Begin, then Space: the ring runs by itself, and says when to move the camera.',
  ]
  return (
    <ol class="shoot-advice">
      {steps.map((words) => (
        <li key={words}>{words}</li>
      ))}
    </ol>
  )
}

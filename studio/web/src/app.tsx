// The bar at the top, and the page that the address names.
import { useEffect, useState } from 'preact/hooks'

import { api } from './api'
import { Bar } from './bar'
import { kPages, pageAt, pagesOf } from './page_table'
import { DoorPage } from './pages/door'
import { doorApi } from './pages/door/door_api'
import type { DoorState } from './pages/door/door_api'
import { NewProjectPage } from './pages/new_project'
import { useUpload } from './pages/new_project/upload'
import { StudioState, useStudio, Waiting } from './state'
import { ThemeButton } from './theme_button'
import { percent } from './words'

function useRoute(): string {
  const read = () => location.hash.replace(/^#\/?/, '').split('/')[0] || 'poses'
  const [route, setRoute] = useState(read)
  useEffect(() => {
    const changed = () => setRoute(read())
    addEventListener('hashchange', changed)
    return () => removeEventListener('hashchange', changed)
  }, [])
  return route
}

function RunState() {
  const { project, steps, running, connected, tabs, complain, reload } = useStudio()
  if (!connected) return <span class="bad">The studio does not answer</span>
  if (running) {
    const left = running.left === null ? '' : `, ${running.left} left`
    return (
      <>
        <a href="#/run" class="soft number small" style="text-decoration:none">
          {percent(running.overall)}
          {left}
        </a>
        <Bar label="The run" share={running.overall} />
        <button onClick={() => api.stop().catch(complain)}>Stop</button>
      </>
    )
  }
  const waiting = steps.steps.filter((step) => step.state !== 'done' && step.state !== 'missing')
  return (
    <>
      {tabs > 1 && <span class="tag warn">open in {tabs} tabs</span>}
      {steps.locked_by ? (
        <span class="warn" title={steps.locked_by}>
          Another program runs this project
        </span>
      ) : project.problem ? null : (
        <button
          class={waiting.length > 0 ? 'main' : ''}
          disabled={waiting.length === 0}
          onClick={() => api.run({}).then(reload).catch(complain)}
        >
          {waiting.length > 0 ? 'Run' : 'Up to date'}
        </button>
      )}
    </>
  )
}

function Shell() {
  const { project } = useStudio()
  const route = useRoute()
  const current = pageAt(project, route)
  useEffect(() => {
    document.title = `${current.name} · ${project.name || 'Keypose studio'}`
  }, [current, project.name])
  // A project exists from its first photograph on; the page that sends them stays until the last.
  const sending = useUpload() !== null
  const isNew = sending || project.empty
  const early = sending ? undefined : current.early
  const Page = isNew ? (early?.page ?? NewProjectPage) : current.page
  const newPages = kPages.flatMap(({ path, early: its }) => (its ? { path, name: its.name } : []))
  const pages = isNew ? newPages : pagesOf(project)
  return (
    <>
      <header class="top">
        <div class="brand">
          <a href="#/projects" title="All projects">
            Keypose
          </a>{' '}
          <span title={project.folder}>{project.name}</span>
        </div>
        {!sending && (
          <nav class="pages" aria-label="Pages">
            {pages.map((one) => (
              <a
                key={one.path}
                href={`#/${one.path}`}
                aria-current={one.path === current.path ? 'page' : undefined}
              >
                {one.name}
              </a>
            ))}
          </nav>
        )}
        <div class="state">
          {!isNew && <RunState />}
          <ThemeButton />
        </div>
      </header>
      {project.problem && !isNew && !current.needsNoPlan ? (
        <main class="empty">
          <h1>The project’s file, pipeline.yaml, has a mistake</h1>
          <pre>{project.problem}</pre>
          <p>Mend it in an editor; this page notices at once.</p>
          {project.kind === 'performance' && (
            <p>
              Are the cameras not calibrated yet? <a href="#/cameras">Calibrate them by points</a>
            </p>
          )}
        </main>
      ) : (
        <Page />
      )}
    </>
  )
}

const kDoorPages = ['projects', 'guide']

/** The open project; without one, or when it is asked for, the page before all projects. */
export function App() {
  const route = useRoute()
  const asked = kDoorPages.includes(route)
  const [door, setDoor] = useState<DoorState | null>(null)
  const [answered, setAnswered] = useState(false)
  useEffect(() => {
    // Where it cannot be told, the project's page says what is wrong.
    doorApi
      .state()
      .then(setDoor, () => setDoor(null))
      .finally(() => setAnswered(true))
  }, [asked])
  if (!answered) return <Waiting />
  if (door && (asked || door.open === ''))
    return <DoorPage first={door} guide={route === 'guide'} />
  return (
    <StudioState>
      <Shell />
    </StudioState>
  )
}

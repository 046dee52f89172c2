// The page before all projects: those that are known, a new one, examples, how to photograph.
import { useEffect, useState } from 'preact/hooks'

import { ThemeButton } from '../theme_button'
import { doorApi } from './door/door_api'
import type { DoorState, KnownProject, ProjectCard } from './door/door_api'
import { nameFault, stateWords, whenWords } from './door/door_words'
import { Examples } from './door/examples'
import { Guide } from './door/guide'
import './door/door.css'

/** Shows the project that was opened, from its beginning or a page of it. */
export function enter(page = ''): void {
  location.hash = `#/${page}`
  location.reload()
}

const wordsOf = (error: unknown) => (error instanceof Error ? error.message : String(error))

function NoPicture({ name }: { name: string }) {
  return (
    <div class="door-picture none" aria-hidden="true">
      {name.slice(0, 1)}
    </div>
  )
}

function Picture({ folder, name }: { folder: string; name: string }) {
  const [gone, setGone] = useState(false)
  if (gone) return <NoPicture name={name} />
  return (
    <img
      class="door-picture"
      src={doorApi.pictureUrl(folder)}
      alt=""
      loading="lazy"
      onError={() => setGone(true)}
    />
  )
}

function useCard(project: KnownProject): ProjectCard | null {
  const [card, setCard] = useState<ProjectCard | null>(null)
  useEffect(() => {
    if (!project.there) return
    doorApi.card(project.folder).then(setCard, () => setCard(null))
  }, [project.folder, project.there])
  return card
}

interface Acts {
  open: (folder: string, page?: string) => void
  forget: (folder: string) => void
}

function Known({ project, isOpen, acts }: { project: KnownProject; isOpen: boolean; acts: Acts }) {
  const card = useCard(project)
  const { folder, name } = project
  const bad = card?.state === 'failed' || card?.state === 'broken'
  return (
    <li class={project.there ? 'door-card' : 'door-card gone'}>
      {card?.picture ? <Picture folder={folder} name={name} /> : <NoPicture name={name} />}
      <div class="door-facts">
        <h2 title={name}>{name}</h2>
        {project.there ? (
          <p class={bad ? 'bad' : 'soft'} title={card?.problem || undefined}>
            {card ? stateWords(card) : ' '}
            {isOpen && ' · open now'}
          </p>
        ) : (
          <p class="warn">moved, or gone: there is no project in this folder</p>
        )}
        <p class="soft small door-folder" title={folder}>
          {folder}
        </p>
        <p class="soft small">{whenWords(project.opened, Date.now() / 1000)}</p>
      </div>
      <div class="door-acts">
        {project.there && (
          <button class="main" aria-label={`Open ${name}`} onClick={() => acts.open(folder)}>
            Open
          </button>
        )}
        <button
          class="quiet"
          aria-label={`Take off the list: ${name}`}
          title="Its folder stays as it is"
          onClick={() => acts.forget(folder)}
        >
          Take off the list
        </button>
      </div>
    </li>
  )
}

function NewOne({ home, act }: { home: string; act: (name: string) => void }) {
  const [name, setName] = useState('')
  const fault = nameFault(name.trim())
  return (
    <form
      class="card stack"
      onSubmit={(event) => {
        event.preventDefault()
        if (!fault) act(name.trim())
      }}
    >
      <h2>New project</h2>
      <label for="door-name">Its name</label>
      <input
        id="door-name"
        value={name}
        autocomplete="off"
        onInput={(event) => setName(event.currentTarget.value)}
      />
      <p class="soft small">
        {name && fault ? <span class="bad">{fault}</span> : <>A folder of that name, in {home}</>}
      </p>
      <button class="main" disabled={fault !== ''}>
        Make it
      </button>
    </form>
  )
}

/** Says beside the form why a folder cannot be opened. */
function OpenOne({ act }: { act: (folder: string) => Promise<unknown> }) {
  const [folder, setFolder] = useState('')
  const [fault, setFault] = useState('')
  return (
    <form
      class="card stack"
      onSubmit={(event) => {
        event.preventDefault()
        if (folder.trim()) act(folder.trim()).catch((error) => setFault(wordsOf(error)))
      }}
    >
      <h2>Open a folder</h2>
      <label for="door-folder">Where it is</label>
      <input
        id="door-folder"
        value={folder}
        autocomplete="off"
        spellcheck={false}
        placeholder="/home/me/fox"
        aria-invalid={fault !== ''}
        aria-describedby="door-folder-fault"
        onInput={(event) => {
          setFolder(event.currentTarget.value)
          setFault('')
        }}
      />
      <p id="door-folder-fault" class="bad small" role="alert" hidden={fault === ''}>
        {fault}
      </p>
      <p class="soft small">
        A project’s, or an empty one. In a file manager: Ctrl L shows a folder’s path, Ctrl C takes
        it.
      </p>
      <button disabled={!folder.trim()}>Open it</button>
    </form>
  )
}

function OtherBrowser({ complain }: { complain: (error: unknown) => void }) {
  const [address, setAddress] = useState('')
  return (
    <div class="row">
      <button
        onClick={() =>
          doorApi.address().then((answer) => setAddress(answer.address), complain)
        }
      >
        Another browser
      </button>
      {address && (
        <>
          <input
            class="door-address mono"
            readOnly
            aria-label="Address for another browser"
            value={address}
            onFocus={(event) => event.currentTarget.select()}
          />
          <span class="soft small">lets one browser on this machine in, once</span>
        </>
      )}
    </div>
  )
}

function Ended() {
  return (
    <main class="empty">
      <h1>The studio has ended</h1>
      <p>
        A run goes on without it. Start the studio again from the menu of applications, or with{' '}
        <code>keypose studio</code>.
      </p>
    </main>
  )
}

function useDoor(first: DoorState) {
  const [door, setDoor] = useState(first)
  // It was asked for again: a project was left for this page.
  useEffect(() => setDoor(first), [first])
  const [fault, setFault] = useState('')
  const complain = (error: unknown) => setFault(wordsOf(error))
  const ask = (question: Promise<DoorState>) =>
    question.then((next) => {
      setFault('')
      setDoor(next)
      return next
    })
  const busy = door.making?.at_work ?? false
  useEffect(() => {
    if (!busy) return
    const timer = setInterval(() => void doorApi.state().then(setDoor, complain), 700)
    return () => clearInterval(timer)
  }, [busy])
  return { door, fault, complain, ask, dismiss: () => setFault('') }
}

export function DoorPage({ first, guide }: { first: DoorState; guide: boolean }) {
  const { door, fault, complain, ask, dismiss } = useDoor(first)
  const [ended, setEnded] = useState(false)
  useEffect(() => {
    document.title = guide ? 'How to photograph · Keypose studio' : 'Projects · Keypose studio'
  }, [guide])
  const open = (folder: string, page?: string) =>
    void ask(doorApi.open(folder)).then(() => enter(page), complain)
  const acts: Acts = {
    open,
    forget: (folder) => void ask(doorApi.forget(folder)).catch(complain),
  }
  return (
    <>
      <header class="top">
        <div class="brand">
          <a href="#/projects">Keypose</a>
        </div>
        <nav class="pages" aria-label="Pages">
          <a href="#/projects" aria-current={guide ? undefined : 'page'}>
            Projects
          </a>
          <a href="#/guide" aria-current={guide ? 'page' : undefined}>
            How to photograph
          </a>
        </nav>
        <div class="state">
          {door.open && (
            <a class="button" href="#/">
              Back to {door.open.split('/').pop()}
            </a>
          )}
          <ThemeButton />
        </div>
      </header>
      {ended ? (
        <Ended />
      ) : guide ? (
        <Guide />
      ) : (
        <main class="door">
          <div class={door.projects.length > 0 ? 'door-sheet' : 'door-sheet first'}>
            <section class="door-known" aria-label="Projects">
              <h1>{door.projects.length > 0 ? 'Projects' : 'Welcome'}</h1>
              {door.projects.length === 0 && (
                <p class="soft door-lead">
                  Keypose makes a 3D animation of photographs of a handmade character. Read{' '}
                  <a href="#/guide">how to photograph</a> it, make a project of your photographs, or
                  look at an example first.
                </p>
              )}
              <ul class="door-list">
                {door.projects.map((project) => (
                  <Known
                    key={project.folder}
                    project={project}
                    isOpen={project.folder === door.open}
                    acts={acts}
                  />
                ))}
              </ul>
            </section>
            <div class="door-ways">
              <NewOne
                home={door.home}
                act={(name) => void ask(doorApi.make(name)).then(() => enter(), complain)}
              />
              <OpenOne act={(folder) => ask(doorApi.open(folder)).then(() => enter())} />
            </div>
            <Examples door={door} ask={ask} complain={complain} open={open} />
            <footer class="door-foot">
              <OtherBrowser complain={complain} />
              <button
                onClick={() =>
                  void doorApi.end().then(() => setEnded(true), complain)
                }
              >
                End the studio
              </button>
            </footer>
          </div>
        </main>
      )}
      <div class="notices" role="status" aria-live="polite">
        {fault && (
          <div class="bad">
            <span>{fault}</span>
            <button class="quiet" aria-label="Dismiss" onClick={dismiss}>
              ×
            </button>
          </div>
        )}
      </div>
    </>
  )
}

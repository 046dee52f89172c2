// What the page before all projects says. Pure.
import { count } from '../../words'
import type { ProjectCard } from './door_api'

export interface ExampleWords {
  name: string
  about: string
  /** how long it takes */
  time: string
}

/** By kind, in the order in which they are shown. Times: two cores that do nothing else. */
export const kExamples: Record<string, ExampleWords> = {
  finished: {
    name: 'A clay character, finished',
    about: 'Two poses, the film between them, the report. It runs by itself; look on, or come back.',
    time: 'a minute to draw, 5 to 10 to run',
  },
  two: {
    name: 'Two poses, photographed all round',
    about: 'Press Run, mend a mask, pick landmarks on both, set the timing.',
    time: 'about a minute',
  },
  six: {
    name: 'A second pose from six photographs',
    about: 'One pose all round; the other is bent from it when you press Run.',
    time: 'about a minute',
  },
  film: {
    name: 'A character in a film',
    about: 'Filmed twelve times a second on its set; Shot makes the pictures between.',
    time: 'about two minutes',
  },
  dance: {
    name: 'An actor in films',
    about: 'Six cameras; Run finds the movement, which a scan can take over.',
    time: 'about a minute',
  },
  puppet: {
    name: 'A puppet of wire',
    about: 'With a simulated controller: press Use the example, then Begin, and record a take.',
    time: 'some seconds',
  },
}

/** How far a project is. */
export function stateWords(card: ProjectCard): string {
  const of = `${card.done} of ${count(card.steps, 'step')} done`
  switch (card.state) {
    case 'running':
      return `running: ${of}`
    case 'done':
      return 'finished'
    case 'failed':
      return `a step failed; ${of}`
    case 'begun':
      return of
    case 'new':
      return 'not run yet'
    case 'empty':
      return 'puppet of wire'
    case 'broken':
      return 'its file has a mistake'
  }
}

/** When a project was opened last. @param now  [s since 1970] */
export function whenWords(opened: number, now: number): string {
  const day = (seconds: number) => new Date(1000 * seconds).toDateString()
  const at = new Date(1000 * opened)
  const time = `${String(at.getHours()).padStart(2, '0')}:${String(at.getMinutes()).padStart(2, '0')}`
  if (day(opened) === day(now)) return `today, ${time}`
  if (day(opened) === day(now - 86400)) return `yesterday, ${time}`
  return at.toLocaleDateString('en-GB', { day: 'numeric', month: 'long', year: 'numeric' })
}

/** Why a project cannot have that name yet, or ''. As known_projects.cpp says. */
export function nameFault(name: string): string {
  if (name === '') return 'Give it a name.'
  if (name.startsWith('.')) return 'A name does not begin with a dot.'
  return /[/\\\n\t\0]/.test(name) ? 'Letters, digits, spaces and dashes.' : ''
}

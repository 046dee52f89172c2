import { render } from 'preact'

import { App } from './app'
import { holdStrayDrops } from './stray_drops'
import './style.css'

holdStrayDrops()
render(<App />, document.getElementById('app')!)
